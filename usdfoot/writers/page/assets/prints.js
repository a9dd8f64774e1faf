/** Footprints of all agents in one draw: faint before their strike, full while the foot stands, paler after. */
page.prints = (() => {
  const VERTEX = `
    ${page.copies.SHADER}
    uniform highp sampler2D places;  // and size
    uniform highp sampler2D turns;
    uniform highp sampler2D times;  // strike, liftoff, side
    uniform float time;
    uniform vec3 left, right;
    varying vec4 vColor;
    vec3 turned(vec4 turn, vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
    void main() {
      vec4 place = row(places);
      vec4 when = row(times);
      vec3 corner = position * vec3(when.z > 0.5 ? -place.w : place.w, 1.0, place.w);
      float alpha = time < when.x ? 0.35 : time <= when.y ? 1.0 : 0.6;
      vColor = vec4(when.z > 0.5 ? right : left, alpha);
      gl_Position = projectionMatrix * viewMatrix * vec4(place.xyz + turned(row(turns), corner), 1.0);
    }`;
  const FRAGMENT = `
    varying vec4 vColor;
    void main() { gl_FragColor = vColor; }`;
  const SMALL = 14; // pixels below which a print is a rectangle
  const TINY = 1; // pixels below which it is not drawn
  const SHAPED = 3000; // prints that may be more than that
  const LIFT = 0.006; // over the ground, against flicker [m]

  function create(crowd, state, scene) {
    const { THREE } = window;
    const { arrays } = crowd;
    const count = arrays.sides.length;
    const shaped = page.copies.geometry(outline(crowd.header.printOutline), Math.min(count, SHAPED));
    const plain = page.copies.geometry(rectangle(crowd.header.printOutline), count);
    const tables = { places: page.copies.table(count), turns: page.copies.table(count), times: page.copies.table(count) };
    const [places, turns, times] = Object.values(tables).map((table) => table.image.data);
    const uniforms = { time: { value: 0 }, left: { value: new THREE.Color() }, right: { value: new THREE.Color() } };
    for (const [name, table] of Object.entries(tables)) uniforms[name] = { value: table };
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
      side: THREE.DoubleSide,
      uniforms,
    });
    const meshes = [shaped, plain].map(({ geometry }) => new THREE.Mesh(geometry, material));
    for (const mesh of meshes) {
      mesh.frustumCulled = false;
      scene.add(mesh);
    }
    let drawn = 0;

    /** Prints of the agents shown. */
    function choose() {
      let print = 0;
      for (const agent of crowd.agents) {
        if (!page.bones.isDrawn(state, agent.index)) continue;
        for (let step = agent.firstStep; step < agent.firstStep + agent.stepCount; step++, print++) {
          places.set(arrays.positions.subarray(3 * step, 3 * step + 3), 4 * print);
          places[4 * print + 3] = agent.stick.footLength;
          turns.set(arrays.orientations.subarray(4 * step, 4 * step + 4), 4 * print);
          times.set([arrays.strikeTimes[step], arrays.liftoffTimes[step], arrays.sides[step]], 4 * print);
        }
      }
      drawn = print;
      for (const table of Object.values(tables)) table.needsUpdate = true;
    }

    /** Prints in sight of a lens, the large ones in their shape. */
    function pose(lens) {
      for (const mesh of meshes) mesh.visible = state.prints;
      material.uniforms.time.value = state.time;
      if (!state.prints) return;
      const [large, small] = [[], []];
      for (let print = 0; print < drawn; print++) {
        const size = places[4 * print + 3];
        const scale = page.copies.scaleAt(lens, places[4 * print], places[4 * print + 1], places[4 * print + 2], 2 * size);
        if (scale * size > TINY) (scale * size > SMALL && large.length < shaped.most ? large : small).push(print);
      }
      shaped.show(large);
      plain.show(small);
    }

    function color() {
      material.uniforms.left.value.set(page.dom.color("left"));
      material.uniforms.right.value.set(page.dom.color("right"));
    }

    return { choose, pose, color };
  }

  /** The left print as a fan around its middle. */
  function outline(corners) {
    const points = [0, LIFT, -0.45];
    const indices = [];
    const count = corners.length / 2;
    for (let i = 0; i < count; i++) {
      points.push(corners[2 * i], LIFT, corners[2 * i + 1]);
      indices.push(0, 1 + i, 1 + ((i + 1) % count));
    }
    return { attributes: { position: [3, points] }, indices };
  }

  /** The rectangle around the left print. */
  function rectangle(corners) {
    const [xs, zs] = [0, 1].map((axis) => corners.filter((_, i) => i % 2 === axis));
    const [left, right, back, front] = [Math.min(...xs), Math.max(...xs), Math.min(...zs), Math.max(...zs)];
    const points = [left, LIFT, back, right, LIFT, back, left, LIFT, front, right, LIFT, front];
    return { attributes: { position: [3, points] }, indices: [0, 1, 2, 1, 3, 2] };
  }

  return { create };
})();
