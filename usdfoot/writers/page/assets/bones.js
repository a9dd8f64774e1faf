/** Stick figures of all agents in one draw: every bone is a copy of one capsule, laid from joint to joint. */
page.bones = (() => {
  const THIN = 0.042; // radius over leg length
  const HEAD = 0.1; // radius and height over leg length
  const SMALL = 60; // pixels below which a leg is of ribbons that face the camera
  const TINY = 14; // pixels below which a figure is its trunk and two straight legs
  const ROUND = 1500; // bones that may be more than that

  /** Unit ribbon: normals at its edges, which lean towards the camera as a tube's would. */
  const RIBBON = {
    attributes: { position: [3, [-0.9, 0.44, 0, 0.9, 0.44, 0, -0.9, 0.44, 0, 0.9, 0.44, 0]], along: [1, [0, 0, 1, 1]] },
    indices: [0, 1, 2, 1, 3, 2],
  };

  const VERTEX = `
    ${page.copies.SHADER}
    uniform highp sampler2D start, end;
    uniform highp sampler2D paint;  // color and radius
    attribute float along;
    uniform float pixel;  // its size at a distance of 1
    varying vec3 vNormal, vColor, vPlace;
    void main() {
      vec3 from = row(start).xyz;
      vec3 axis = row(end).xyz - from;
      vec4 tone = row(paint);
      vec3 middle = from + along * axis;
      float size = length(axis);
      axis = size > 1e-5 ? axis / size : vec3(0.0, 1.0, 0.0);
      vec3 across = cross(axis, cameraPosition - middle);
      size = length(across);
      across = size > 1e-5 ? across / size : vec3(axis.y, axis.z, axis.x);
      vNormal = across * position.x + cross(across, axis) * position.y + axis * position.z;
      vColor = tone.rgb;
      float radius = max(tone.a, 0.9 * pixel * distance(middle, cameraPosition));  // never thinner than two pixels
      vec4 place = viewMatrix * vec4(middle + radius * vNormal, 1.0);
      vPlace = place.xyz;
      gl_Position = projectionMatrix * place;
    }`;
  const FRAGMENT = `
    varying vec3 vNormal, vColor, vPlace;
    void main() {
      vec3 normal = normalize(vNormal);
      float sky = 0.62 + 0.25 * normal.y + 0.22 * max(dot(normal, normalize(vec3(0.5, 0.8, 0.4))), 0.0);
      gl_FragColor = vec4(vColor * sky, 1.0);
    }`;

  function create(crowd, state, scene) {
    const { THREE } = window;
    const limbs = crowd.header.stickFigures.map(limbsOf);
    const coarse = crowd.header.stickFigures.map((stick, i) => coarseOf(stick, limbs[i]));
    const most = crowd.agents.reduce((sum, agent) => sum + limbs[crowd.arrays.stickIndices[agent.index]].length, 0);
    const round = page.copies.geometry(capsule(10, 3), Math.min(most + 1, ROUND));
    const flat = page.copies.geometry(RIBBON, most + 1);
    const tables = { start: page.copies.table(most + 1), end: page.copies.table(most + 1), paint: page.copies.table(most + 1) };
    const [starts, ends, paints] = Object.values(tables).map((table) => table.image.data);
    const uniforms = { pixel: { value: 0 } };
    for (const [name, table] of Object.entries(tables)) uniforms[name] = { value: table };
    const material = new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, side: THREE.DoubleSide });
    for (const { geometry } of [round, flat]) {
      const mesh = new THREE.Mesh(geometry, material);
      mesh.frustumCulled = false;
      scene.add(mesh);
    }

    const root = new Float32Array(3);
    const joints = new Float32Array(3 * Math.max(...crowd.header.stickFigures.map((stick) => stick.parents.length)));

    /** Everybody shown and in sight of a lens, where they are now. */
    function pose(lens) {
      const [large, small] = [[], []];
      let bone = 0;
      for (const agent of crowd.agents) {
        if (!isDrawn(state, agent.index)) continue;
        const own = limbs[crowd.arrays.stickIndices[agent.index]];
        const { legLength } = agent.stick;
        const place = page.crowd.frameAt(crowd, agent, state.time);
        page.crowd.rootAt(crowd, agent, place, root);
        const scale = page.copies.scaleAt(lens, root[0], root[1] + legLength, root[2], 2 * legLength);
        if (scale) {
          page.crowd.jointsAt(crowd, agent, place, root, joints, 0);
          const height = scale * legLength;
          const rows = height > SMALL && large.length + own.length < round.most ? large : small;
          const drawn = height > TINY ? own : coarse[crowd.arrays.stickIndices[agent.index]];
          for (const limb of drawn) {
            lay(limb, legLength, bone + limb.row);
            rows.push(bone + limb.row);
          }
        }
        bone += own.length;
      }
      if (crowd.agents.length > 1) large.push(point(bone));
      round.show(large);
      flat.show(small);
      tables.start.needsUpdate = true;
      tables.end.needsUpdate = true;
    }

    /** A bone from joint to joint. */
    function lay({ from, to, rise }, legLength, bone) {
      for (let axis = 0; axis < 3; axis++) {
        starts[4 * bone + axis] = joints[3 * from + axis];
        ends[4 * bone + axis] = joints[3 * to + axis];
      }
      ends[4 * bone + 1] += rise * legLength;
    }

    /** A pointer over the chosen agent. */
    function point(bone) {
      const agent = crowd.agents[state.agent];
      page.crowd.rootAt(crowd, agent, page.crowd.frameAt(crowd, agent, state.time), root);
      for (const [places, height] of [[starts, 2.5], [ends, 3]]) {
        places.set([root[0], root[1] + height * agent.stick.legLength, root[2]], 4 * bone);
      }
      return bone;
    }

    /** Colors of everybody shown: legs by side, bodies by how they do, the chosen one lit up. */
    function color() {
      const colors = palette(THREE);
      let bone = 0;
      for (const agent of crowd.agents) {
        if (!isDrawn(state, agent.index)) continue;
        const chosen = agent.index === state.agent;
        const body = chosen ? colors.chosen : crowd.agentSeverity[agent.index] > 1 ? colors.over : colors.body;
        for (const limb of limbs[crowd.arrays.stickIndices[agent.index]]) {
          const tone = limb.side === 0 ? colors.left : limb.side === 1 ? colors.right : body;
          paints.set([tone.r, tone.g, tone.b, limb.radius * agent.stick.legLength], 4 * bone);
          bone++;
        }
      }
      const { r, g, b } = colors.chosen;
      paints.set([r, g, b, 1.5 * THIN * crowd.agents[state.agent].stick.legLength], 4 * bone);
      tables.paint.needsUpdate = true;
    }

    /** Called with the size of a pixel at a distance of 1 when the view changes its size. */
    function sharpen(pixel) {
      uniforms.pixel.value = pixel;
    }

    return { pose, color, sharpen };
  }

  /** Whether an agent is to be seen: in the filter, and not hidden by the chosen one. */
  function isDrawn(state, agent) {
    return state.alone ? agent === state.agent : state.shown[agent] === 1 || agent === state.agent;
  }

  /** Bones of a stick figure: row, joints from and to, side, and over leg length radius and how far the end is raised. */
  function limbsOf({ parents, sides, head }) {
    const limbs = [];
    parents.forEach((parent, joint) => {
      if (parent < 0) return;
      limbs.push({ row: limbs.length, from: parent, to: joint, side: sides[joint], radius: THIN, rise: 0 });
    });
    if (head >= 0) limbs.push({ row: limbs.length, from: head, to: head, side: 2, radius: HEAD, rise: HEAD });
    return limbs;
  }

  /** The same from far away: hips to ankles and pelvis to head, each in the row of a bone of its side. */
  function coarseOf({ head }, limbs) {
    const legs = [0, 1].map((side) => {
      const own = limbs.filter((limb) => limb.side === side);
      return own.length ? { ...own[0], to: own[Math.max(0, own.length - 2)].to } : null;
    });
    if (head < 0 || legs.includes(null)) return limbs;
    return [{ ...limbs.find((limb) => limb.side === 2), from: 0, to: head }, ...legs];
  }

  function palette(THREE) {
    const tone = (name) => new THREE.Color(page.dom.color(name));
    return { left: tone("left"), right: tone("right"), body: tone("body"), over: tone("over"), chosen: tone("chosen") };
  }

  /** Unit capsule: normals of half a sphere around either end of a line, which end in `along`. */
  function capsule(around, caps) {
    const normals = [];
    const ends = [];
    const indices = [];
    for (let ring = -caps - 1; ring <= caps + 1; ring++) {
      if (ring === 0) continue;
      const tilt = (Math.sign(ring) * (Math.abs(ring) - 1) * Math.PI) / (2 * caps);
      for (let i = 0; i < around; i++) {
        const angle = (2 * Math.PI * i) / around;
        normals.push(Math.cos(tilt) * Math.cos(angle), Math.cos(tilt) * Math.sin(angle), Math.sin(tilt));
        ends.push(ring > 0 ? 1 : 0);
      }
    }
    for (let ring = 0; ring < 2 * caps + 1; ring++) {
      for (let i = 0; i < around; i++) {
        const [a, b] = [ring * around + i, ring * around + ((i + 1) % around)];
        indices.push(a, b, a + around, b, b + around, a + around);
      }
    }
    return { attributes: { position: [3, normals], along: [1, ends] }, indices };
  }

  return { create, isDrawn };
})();
