/**
 * Many copies of a small shape in one draw: each vertex says which copy it is of, what differs stands in tables.
 * Instancing would be less to upload, but browsers that draw without a graphics card take every instance for a draw.
 */
page.copies = (() => {
  const WIDTH = 1024; // texels in a row of a table

  /** For vertex shaders: the row of this vertex's copy in a table. */
  const SHADER = `
    attribute float copy;
    vec4 row(highp sampler2D table) {
      int number = int(copy);
      return texelFetch(table, ivec2(number % ${WIDTH}, number / ${WIDTH}), 0);
    }`;

  /** At most `most` copies of a shape: attributes by name, each [size of an item, values], and corners of triangles. */
  function geometry({ attributes, indices }, most) {
    const { THREE } = window;
    const result = new THREE.BufferGeometry();
    const vertices = attributes.position[1].length / 3;
    const corners = new Uint32Array(most * indices.length);
    for (let copy = 0; copy < most; copy++) {
      for (let i = 0; i < indices.length; i++) corners[copy * indices.length + i] = copy * vertices + indices[i];
    }
    for (const [name, [size, values]] of Object.entries(attributes)) {
      const every = new Float32Array(most * values.length);
      for (let copy = 0; copy < most; copy++) every.set(values, copy * values.length);
      result.setAttribute(name, new THREE.BufferAttribute(every, size));
    }
    const numbers = new THREE.BufferAttribute(new Float32Array(most * vertices), 1).setUsage(THREE.DynamicDrawUsage);
    result.setAttribute("copy", numbers);
    result.setIndex(new THREE.BufferAttribute(corners, 1));

    /** Draw these copies from now on: numbers of rows, as many as there is room for. */
    function show(rows) {
      const count = Math.min(rows.length, most);
      for (let i = 0; i < count; i++) numbers.array.fill(rows[i], i * vertices, (i + 1) * vertices);
      numbers.updateRange.count = count * vertices;
      numbers.needsUpdate = true;
      result.setDrawRange(0, count * indices.length);
    }

    return { geometry: result, most, show };
  }

  /** Four numbers a copy for a shader to read, all 0: a texture whose `image.data` is to be filled. */
  function table(count) {
    const { THREE } = window;
    const height = Math.max(1, Math.ceil(count / WIDTH));
    return new THREE.DataTexture(new Float32Array(4 * WIDTH * height), WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
  }

  /**
   * How large a metre is at a place in the picture [pixels], 0 where a ball about the place is not in sight.
   * `lens` is what lens() gives, `margin` the ball's radius [m].
   */
  function scaleAt({ matrix, pixels, wide }, x, y, z, margin) {
    const depth = matrix[3] * x + matrix[7] * y + matrix[11] * z + matrix[15];
    if (depth < -margin) return 0;
    const across = matrix[0] * x + matrix[4] * y + matrix[8] * z + matrix[12];
    const up = matrix[1] * x + matrix[5] * y + matrix[9] * z + matrix[13];
    const room = Math.max(depth, 0) + wide * margin;
    return Math.abs(across) > room || Math.abs(up) > room ? 0 : pixels / Math.max(depth, 0.1);
  }

  /** The camera as scaleAt() takes it, for a canvas so many pixels high. */
  function lens(camera, height) {
    camera.updateMatrixWorld();
    const { THREE } = window;
    const { elements } = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const focal = camera.projectionMatrix.elements;
    return { matrix: elements, pixels: 0.5 * height * focal[5], wide: 1 + Math.max(focal[0], focal[5]) };
  }

  return { SHADER, geometry, table, scaleAt, lens };
})();
