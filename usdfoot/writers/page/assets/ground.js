/** The terrain, or a plane where there is none, with lines every metre. */
page.ground = (() => {
  const VERTEX = `
    attribute float walkable;
    varying vec3 vPlace;
    varying float vWalkable, vLight;
    void main() {
      vPlace = position;
      vWalkable = walkable;
      vec3 up = normal.y < 0.0 ? -normal : normal;
      vLight = 0.5 + 0.5 * max(dot(up, normalize(vec3(0.45, 0.8, 0.3))), 0.0) / 0.84;
      gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
    }`;
  const FRAGMENT = `
    varying vec3 vPlace;
    varying float vWalkable, vLight;
    uniform vec3 base, lines, barred, sky, middle;
    uniform float reach;
    float grid(float spacing) {
      vec2 place = vPlace.xz / spacing;
      vec2 width = fwidth(place);
      vec2 line = abs(fract(place - 0.5) - 0.5) / max(width, vec2(1e-6));
      float fade = 1.0 - smoothstep(0.2, 0.6, max(width.x, width.y));
      return (1.0 - min(min(line.x, line.y), 1.0)) * fade;
    }
    void main() {
      vec3 color = mix(barred, base, step(0.5, vWalkable)) * vLight;
      float line = max(max(0.35 * grid(1.0), 0.6 * grid(5.0)), max(0.7 * grid(50.0), 0.8 * grid(500.0)));
      color = mix(color, lines, line);
      gl_FragColor = vec4(mix(color, sky, smoothstep(0.55, 1.0, distance(vPlace.xz, middle.xz) / reach)), 1.0);
    }`;

  function create(crowd, scene, { center, radius }) {
    const { THREE } = window;
    const { groundPoints, groundTriangles, groundWalkable } = crowd.arrays;
    const reach = 3 * radius + 12;
    const geometry = new THREE.BufferGeometry();
    if (groundTriangles.length) {
      geometry.setAttribute("position", new THREE.BufferAttribute(...corners(groundPoints, groundTriangles)));
      const walkable = Float32Array.from(groundTriangles, (_, i) => groundWalkable[Math.floor(i / 3)]);
      geometry.setAttribute("walkable", new THREE.BufferAttribute(walkable, 1));
    } else {
      const [x, y, z] = [center.x, crowd.header.groundLevel - 0.002, center.z];
      const plane = [-1, -1, -1, 1, 1, 1, -1, -1, 1, 1, 1, -1];
      const points = [];
      for (let i = 0; i < 6; i++) points.push(x + reach * plane[2 * i], y, z + reach * plane[2 * i + 1]);
      geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
      geometry.setAttribute("walkable", new THREE.Float32BufferAttribute(new Float32Array(6).fill(1), 1));
    }
    geometry.computeVertexNormals();
    const colors = ["base", "lines", "barred", "sky"];
    const uniforms = { middle: { value: center }, reach: { value: reach } };
    for (const name of colors) uniforms[name] = { value: new THREE.Color() };
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: THREE.DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
      uniforms,
      extensions: { derivatives: true },
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    scene.add(mesh);

    function color() {
      for (const name of colors) uniforms[name].value.set(page.dom.color(`ground-${name}`));
    }

    return { color };
  }

  /** Corners of the triangles one after another, so that each has its own color. */
  function corners(points, triangles) {
    const array = new Float32Array(3 * triangles.length);
    for (let i = 0; i < triangles.length; i++) {
      for (let axis = 0; axis < 3; axis++) array[3 * i + axis] = points[3 * triangles[i] + axis];
    }
    return [array, 3];
  }

  return { create };
})();
