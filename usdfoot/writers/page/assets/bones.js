/** Stick figures of all agents in one draw: every bone is an instance of one capsule, laid from joint to joint. */
page.bones = (() => {
  const THIN = 0.042; // radius over leg length
  const HEAD = 0.1; // radius and height over leg length
  const MANY = 150; // agents from which on capsules are coarser

  const VERTEX = `
    attribute vec3 start, end;
    attribute vec4 paint;  // color and radius
    attribute float along;
    uniform float pixel;  // its size at a distance of 1
    varying vec3 vNormal, vColor, vPlace;
    void main() {
      vec3 axis = end - start;
      float size = length(axis);
      axis = size > 1e-5 ? axis / size : vec3(0.0, 1.0, 0.0);
      vec3 across = normalize(cross(axis, abs(axis.y) < 0.99 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
      vNormal = across * position.x + cross(axis, across) * position.y + axis * position.z;
      vColor = paint.rgb;
      vec3 middle = mix(start, end, along);
      float radius = max(paint.a, 0.9 * pixel * distance(middle, cameraPosition));  // never thinner than two pixels
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
    const most = crowd.agents.reduce((sum, agent) => sum + limbs[crowd.arrays.stickIndices[agent.index]].length, 0);
    const geometry = capsule(THREE, crowd.agents.length > MANY ? { around: 4, caps: 0 } : { around: 10, caps: 3 });
    const buffers = {};
    for (const [name, size] of [["start", 3], ["end", 3], ["paint", 4]]) {
      buffers[name] = new THREE.InstancedBufferAttribute(new Float32Array((most + 1) * size), size);
      buffers[name].setUsage(THREE.DynamicDrawUsage);
      geometry.setAttribute(name, buffers[name]);
    }
    const uniforms = { pixel: { value: 0 } };
    const material = new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    scene.add(mesh);

    const root = new Float32Array(3);
    const joints = new Float32Array(3 * Math.max(...crowd.header.stickFigures.map((stick) => stick.parents.length)));

    /** Everybody shown, where they are now. */
    function pose() {
      let bone = 0;
      for (const agent of crowd.agents) {
        if (!isDrawn(state, agent.index)) continue;
        const place = page.crowd.frameAt(crowd, agent, state.time);
        page.crowd.rootAt(crowd, agent, place, root);
        page.crowd.jointsAt(crowd, agent, place, root, joints, 0);
        for (const { from, to, rise } of limbs[crowd.arrays.stickIndices[agent.index]]) {
          for (let axis = 0; axis < 3; axis++) {
            buffers.start.array[3 * bone + axis] = joints[3 * from + axis];
            buffers.end.array[3 * bone + axis] = joints[3 * to + axis];
          }
          buffers.end.array[3 * bone + 1] += rise * agent.stick.legLength;
          bone++;
        }
      }
      if (crowd.agents.length > 1) bone = point(bone);
      geometry.instanceCount = bone;
      buffers.start.needsUpdate = true;
      buffers.end.needsUpdate = true;
    }

    /** A pointer over the chosen agent. */
    function point(bone) {
      const agent = crowd.agents[state.agent];
      page.crowd.rootAt(crowd, agent, page.crowd.frameAt(crowd, agent, state.time), root);
      for (const [name, height] of [["start", 2.5], ["end", 3]]) {
        buffers[name].array.set([root[0], root[1] + height * agent.stick.legLength, root[2]], 3 * bone);
      }
      return bone + 1;
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
          buffers.paint.array.set([tone.r, tone.g, tone.b, limb.radius * agent.stick.legLength], 4 * bone);
          bone++;
        }
      }
      const { r, g, b } = colors.chosen;
      buffers.paint.array.set([r, g, b, 1.5 * THIN * crowd.agents[state.agent].stick.legLength], 4 * bone);
      buffers.paint.needsUpdate = true;
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

  /** Bones of a stick figure: joints from and to, side, and over leg length radius and how far the end is raised. */
  function limbsOf({ parents, sides, head }) {
    const limbs = [];
    parents.forEach((parent, joint) => {
      if (parent >= 0) limbs.push({ from: parent, to: joint, side: sides[joint], radius: THIN, rise: 0 });
    });
    if (head >= 0) limbs.push({ from: head, to: head, side: 2, radius: HEAD, rise: HEAD });
    return limbs;
  }

  function palette(THREE) {
    const tone = (name) => new THREE.Color(page.dom.color(name));
    return { left: tone("left"), right: tone("right"), body: tone("body"), over: tone("over"), chosen: tone("chosen") };
  }

  /** Unit capsule: normals of half a sphere around either end of a line, which end in `along`; no caps = a tube. */
  function capsule(THREE, { around, caps }) {
    const geometry = new THREE.InstancedBufferGeometry();
    const normals = [];
    const ends = [];
    const indices = [];
    for (let ring = -caps - 1; ring <= caps + 1; ring++) {
      if (ring === 0) continue;
      const tilt = (Math.sign(ring) * (Math.abs(ring) - 1) * Math.PI) / (2 * Math.max(caps, 1));
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
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(normals, 3));
    geometry.setAttribute("along", new THREE.Float32BufferAttribute(ends, 1));
    geometry.setIndex(indices);
    return geometry;
  }

  return { create, isDrawn };
})();
