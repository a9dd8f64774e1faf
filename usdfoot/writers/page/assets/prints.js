/** Footprints of all agents in one draw: faint before their strike, full while the foot stands, paler after. */
page.prints = (() => {
  const VERTEX = `
    attribute vec3 place;
    attribute vec4 turn;
    attribute vec4 when;  // strike, liftoff, side, size
    uniform float time;
    uniform vec3 left, right;
    varying vec4 vColor;
    vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
    void main() {
      vec3 corner = position * vec3(when.z > 0.5 ? -when.w : when.w, 1.0, when.w);
      float alpha = time < when.x ? 0.35 : time <= when.y ? 1.0 : 0.6;
      vColor = vec4(when.z > 0.5 ? right : left, alpha);
      gl_Position = projectionMatrix * viewMatrix * vec4(place + turned(corner), 1.0);
    }`;
  const FRAGMENT = `
    varying vec4 vColor;
    void main() { gl_FragColor = vColor; }`;
  const LIFT = 0.006; // over the ground, against flicker [m]

  function create(crowd, state, scene) {
    const { THREE } = window;
    const { arrays } = crowd;
    const geometry = outline(THREE, crowd.header.printOutline);
    const count = arrays.sides.length;
    const attribute = (size) => new THREE.InstancedBufferAttribute(new Float32Array(count * size), size);
    const buffers = { place: attribute(3), turn: attribute(4), when: attribute(4) };
    for (const [name, buffer] of Object.entries(buffers)) geometry.setAttribute(name, buffer);
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
      side: THREE.DoubleSide,
      uniforms: { time: { value: 0 }, left: { value: new THREE.Color() }, right: { value: new THREE.Color() } },
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    scene.add(mesh);

    /** Prints of the agents shown. */
    function choose() {
      let print = 0;
      for (const agent of crowd.agents) {
        if (!page.bones.isDrawn(state, agent.index)) continue;
        for (let step = agent.firstStep; step < agent.firstStep + agent.stepCount; step++, print++) {
          buffers.place.array.set(arrays.positions.subarray(3 * step, 3 * step + 3), 3 * print);
          buffers.turn.array.set(arrays.orientations.subarray(4 * step, 4 * step + 4), 4 * print);
          const { strikeTimes, liftoffTimes, sides } = arrays;
          buffers.when.array.set([strikeTimes[step], liftoffTimes[step], sides[step], agent.stick.footLength], 4 * print);
        }
      }
      geometry.instanceCount = print;
      for (const buffer of Object.values(buffers)) buffer.needsUpdate = true;
    }

    function pose() {
      mesh.visible = state.prints;
      material.uniforms.time.value = state.time;
    }

    function color() {
      material.uniforms.left.value.set(page.dom.color("left"));
      material.uniforms.right.value.set(page.dom.color("right"));
    }

    return { choose, pose, color };
  }

  /** The left print as a fan around its middle. */
  function outline(THREE, corners) {
    const geometry = new THREE.InstancedBufferGeometry();
    const points = [0, LIFT, -0.45];
    const indices = [];
    const count = corners.length / 2;
    for (let i = 0; i < count; i++) {
      points.push(corners[2 * i], LIFT, corners[2 * i + 1]);
      indices.push(0, 1 + i, 1 + ((i + 1) % count));
    }
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    geometry.setIndex(indices);
    return geometry;
  }

  return { create };
})();
