/** The 3-D view: stick figures on their terrain, a camera to move, a click to choose. */
page.view = (() => {
  const PICK_DISTANCE = 40; // pixels from an agent's middle
  const CLICK = 4; // pixels that the pointer may move in a click
  const SMALLEST = 26; // pixels that a body is high at the beginning
  const BEHIND = [0.54, 0.5, 0.677]; // where the camera is, seen from what it looks at: a unit vector

  function create(crowd, state) {
    const holder = page.dom.byId("view");
    const { THREE } = window;
    let renderer;
    try {
      renderer = new THREE.WebGLRenderer({ antialias: true, powerPreference: "high-performance" });
      if (!renderer.capabilities.isWebGL2) throw new Error("WebGL 1");
    } catch {
      holder.append(page.dom.element("p", { class: "empty" }, "This browser has no WebGL 2: the 3-D view is off."));
      return { draw() {}, frames: 0 };
    }
    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    renderer.domElement.setAttribute("aria-label", "Stick figures on their terrain");
    holder.prepend(renderer.domElement);
    const scene = new THREE.Scene();
    const camera = new THREE.PerspectiveCamera(40, 1, 0.05, 5000);
    const controls = new THREE.OrbitControls(camera, renderer.domElement);
    controls.maxPolarAngle = 0.495 * Math.PI;
    controls.zoomSpeed = 0.8;
    const around = bounds(crowd, crowd.agents);
    const ground = page.ground.create(crowd, scene, around);
    const prints = page.prints.create(crowd, state, scene);
    const bones = page.bones.create(crowd, state, scene);
    const view = { frames: 0, draw, fit, pixel };
    let waiting = false;

    /** Draw soon, once, however often it is asked for. */
    function draw() {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(() => {
        waiting = false;
        view.frames++;
        if (state.follow) follow();
        controls.update();
        const lens = page.copies.lens(camera, holder.clientHeight);
        bones.pose(lens);
        prints.pose(lens);
        renderer.render(scene, camera);
      });
    }

    function choose() {
      bones.color();
      prints.choose();
      draw();
    }

    function paint() {
      scene.background = new THREE.Color(page.dom.color("ground-sky"));
      ground.color();
      prints.color();
      bones.color();
      draw();
    }

    /** The camera from behind and above everybody, or the chosen agent alone. */
    function fit(alone) {
      const agents = alone ? [crowd.agents[state.agent]] : crowd.agents;
      const { center } = alone ? bounds(crowd, agents) : around;
      look(center, fitting(crowd, agents, center, camera));
    }

    /** Everybody, or, where they would be too small to see, the chosen agent and those around. */
    function begin() {
      const { legLength } = crowd.agents[state.agent].stick;
      const pixels = (0.5 * holder.clientHeight) / Math.tan((Math.PI * camera.fov) / 360);
      const farthest = (2 * legLength * pixels) / SMALLEST;
      if (fitting(crowd, crowd.agents, around.center, camera) <= farthest) return fit(false);
      look(chosenPlace(), farthest);
    }

    function look(center, distance) {
      controls.target.copy(center);
      camera.position.set(...BEHIND).multiplyScalar(distance).add(center);
      camera.far = 20 * Math.max(distance, around.radius) + 100;
      camera.near = Math.min(0.05 + distance / 500, 1);
      camera.updateProjectionMatrix();
      draw();
    }

    const chosenPlace = () => new THREE.Vector3(...pelvis(crowd, crowd.agents[state.agent], state.time));

    /** Move the camera as the chosen agent moved. */
    function follow() {
      const shift = chosenPlace().sub(controls.target);
      controls.target.add(shift);
      camera.position.add(shift);
    }

    /** Bring the chosen agent into the picture. */
    function seek() {
      const { x, y, z } = chosenPlace().project(camera);
      if (Math.max(Math.abs(x), Math.abs(y)) > 0.95 || z > 1) follow();
      draw();
    }

    /** Go near the chosen agent when it is first followed. */
    function approach() {
      if (!state.follow) return draw();
      const { legLength } = crowd.agents[state.agent].stick;
      const away = camera.position.clone().sub(controls.target);
      away.setLength(Math.min(away.length(), 7 * legLength));
      camera.position.copy(controls.target).add(away);
      draw();
    }

    function resize() {
      const { clientWidth: width, clientHeight: height } = holder;
      if (!width || !height) return;
      renderer.setSize(width, height);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      bones.sharpen((2 * Math.tan((Math.PI * camera.fov) / 360)) / height);
      draw();
    }

    /** Where on the canvas a place is [pixels], null behind the camera. */
    function pixel(place) {
      const { x, y, z } = new THREE.Vector3(...place).project(camera);
      return z > 1 ? null : [0.5 * (x + 1) * holder.clientWidth, 0.5 * (1 - y) * holder.clientHeight];
    }

    let pressed = null;
    renderer.domElement.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
    renderer.domElement.addEventListener("pointerup", (event) => {
      if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > CLICK) return;
      const found = pick(crowd, state, pixel, [event.offsetX, event.offsetY]);
      if (found >= 0) state.chooseAgent(found);
    });
    controls.addEventListener("change", draw);
    new ResizeObserver(resize).observe(holder);
    state.on("time prints", draw);
    state.on("agent shown alone", choose);
    state.on("agent step", seek);
    state.on("follow", approach);
    state.on("theme", paint);
    explain(crowd);
    resize();
    begin();
    paint();
    choose();
    return view;
  }

  /** What the colors mean. */
  function explain(crowd) {
    const entries = [["left", "left"], ["right", "right"], ["chosen", "chosen agent"]];
    if (crowd.agentSeverity.some((severity) => severity > 1)) entries.push(["over", "over a target"]);
    if (crowd.arrays.groundWalkable.includes(0)) entries.push(["ground-barred", "not walkable"]);
    page.chart.legend(page.dom.byId("overlay"), entries);
  }

  /** Corners of the agents' footsteps, on the ground and at the height of a head. */
  function* corners(crowd, agents) {
    const { positions } = crowd.arrays;
    for (const { firstStep, stepCount, stick } of agents) {
      for (let step = firstStep; step < firstStep + stepCount; step++) {
        const [x, y, z] = positions.subarray(3 * step, 3 * step + 3);
        yield [x, y, z];
        yield [x, y + 2 * stick.legLength, z];
      }
    }
  }

  /** Middle and reach of the agents. */
  function bounds(crowd, agents) {
    const box = new window.THREE.Box3();
    const point = new window.THREE.Vector3();
    for (const corner of corners(crowd, agents)) box.expandByPoint(point.set(...corner));
    const radius = 0.5 * box.getSize(new window.THREE.Vector3()).length();
    return { center: box.getCenter(new window.THREE.Vector3()), radius };
  }

  /** How far away the camera sees all of the agents. */
  function fitting(crowd, agents, center, camera) {
    const { THREE } = window;
    const away = new THREE.Vector3(...BEHIND);
    const right = new THREE.Vector3(0, 1, 0).cross(away).normalize();
    const up = away.clone().cross(right);
    const tangent = Math.tan((Math.PI * camera.fov) / 360);
    const point = new THREE.Vector3();
    let distance = 0;
    for (const corner of corners(crowd, agents)) {
      point.set(...corner).sub(center);
      const wide = Math.max(Math.abs(point.dot(right)) / camera.aspect, Math.abs(point.dot(up))) / tangent;
      distance = Math.max(distance, point.dot(away) + wide);
    }
    return 1.08 * distance;
  }

  /** Where an agent's pelvis is. */
  function pelvis(crowd, agent, time) {
    const place = page.crowd.frameAt(crowd, agent, time);
    const joints = new Float32Array(3 * agent.stick.parents.length);
    page.crowd.jointsAt(crowd, agent, place, page.crowd.rootAt(crowd, agent, place, []), joints, 0);
    return joints.subarray(0, 3);
  }

  /** The agent shown nearest to a click, -1 = none is near. */
  function pick(crowd, state, pixel, [x, y]) {
    let found = -1;
    let nearest = PICK_DISTANCE;
    for (const agent of crowd.agents) {
      if (!page.bones.isDrawn(state, agent.index)) continue;
      const place = pixel(pelvis(crowd, agent, state.time));
      const distance = place ? Math.hypot(x - place[0], y - place[1]) : Infinity;
      if (distance < nearest) [found, nearest] = [agent.index, distance];
    }
    return found;
  }

  return { create, pelvis };
})();
