// Draws arms in 3D into any canvas: one WebGL context for all of them, copied from; without WebGL, thick lines.
mobo.scene = (() => {
  const N = 28;
  // Unit meshes: a cylinder of radius 1 and length 1 along z, a ball of radius 1. Position and normal, 6 numbers a vertex.
  const cylinder = () => {
    const out = [];
    for (let i = 0; i < N; i++) {
      const [a, b] = [i, i + 1].map((k) => [Math.cos((2 * Math.PI * k) / N), Math.sin((2 * Math.PI * k) / N)]);
      const side = ([x, y], z) => [x, y, z, x, y, 0], cap = ([x, y], z) => [x, y, z, 0, 0, 2 * z];
      for (const v of [side(a, -0.5), side(b, -0.5), side(b, 0.5), side(a, -0.5), side(b, 0.5), side(a, 0.5)]) out.push(...v);
      for (const z of [-0.5, 0.5]) out.push(0, 0, z, 0, 0, 2 * z, ...cap(a, z), ...cap(b, z));
    }
    return new Float32Array(out);
  };
  const ball = () => {
    const out = [], M = 14;
    const at = (i, j) => {
      const t = (Math.PI * j) / M, f = (2 * Math.PI * i) / N, v = [Math.sin(t) * Math.cos(f), Math.sin(t) * Math.sin(f), Math.cos(t)];
      return [...v, ...v];
    };
    for (let i = 0; i < N; i++)
      for (let j = 0; j < M; j++)
        for (const [a, b] of [[i, j], [i + 1, j], [i + 1, j + 1], [i, j], [i + 1, j + 1], [i, j + 1]]) out.push(...at(a, b));
    return new Float32Array(out);
  };

  const vertex = `attribute vec3 p; attribute vec3 n; uniform mat4 model; uniform mat4 view; varying vec3 normal; varying vec3 at;
    void main() { vec4 w = model * vec4(p, 1.0); at = w.xyz; normal = mat3(model) * n; gl_Position = view * w; }`;
  const fragment = `precision mediump float; varying vec3 normal; varying vec3 at; uniform vec4 colour; uniform vec3 eye; uniform float flat_;
    void main() {
      vec3 n = normalize(normal), e = normalize(eye - at);
      if (dot(n, e) < 0.0) n = -n;
      float key = max(dot(n, normalize(vec3(0.5, -0.35, 0.9))), 0.0), sky = 0.5 + 0.5 * n.z;
      float shine = pow(max(dot(reflect(-normalize(vec3(0.5, -0.35, 0.9)), n), e), 0.0), 24.0);
      vec3 lit = colour.rgb * (0.42 + 0.28 * sky + 0.42 * key) + 0.10 * shine;
      gl_FragColor = vec4(mix(lit, colour.rgb, flat_), colour.a);
    }`;

  let gl = null, program = null, meshes = null, where = null;
  const begin = () => {
    if (gl !== null) return gl;
    const canvas = document.createElement("canvas");
    gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true, alpha: true }) || false;
    if (!gl) return gl;
    canvas.addEventListener("webglcontextlost", () => { gl = null; });
    const shader = (type, source) => { const s = gl.createShader(type); gl.shaderSource(s, source); gl.compileShader(s); gl.attachShader(program, s); };
    program = gl.createProgram();
    shader(gl.VERTEX_SHADER, vertex);
    shader(gl.FRAGMENT_SHADER, fragment);
    gl.linkProgram(program);
    gl.useProgram(program);
    where = Object.fromEntries(["model", "view", "colour", "eye", "flat_"].map((name) => [name, gl.getUniformLocation(program, name)]));
    where.p = gl.getAttribLocation(program, "p");
    where.n = gl.getAttribLocation(program, "n");
    const mesh = (data) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      return { buffer, count: data.length / 6 };
    };
    meshes = { cylinder: mesh(cylinder()), sphere: mesh(ball()) };
    gl.enableVertexAttribArray(where.p);
    gl.enableVertexAttribArray(where.n);
    gl.enable(gl.DEPTH_TEST);
    return gl;
  };

  // Where the camera is and what it sees: x to the right, y down, in pixels.
  const camera = ({ azimuth, elevation, distance, target }, width, height) => {
    const ce = Math.cos(elevation), se = Math.sin(elevation), ca = Math.cos(azimuth), sa = Math.sin(azimuth);
    const back = [ce * ca, ce * sa, se], right = [-sa, ca, 0], up = [-se * ca, -se * sa, ce];
    const eye = target.map((t, k) => t + distance * back[k]), dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    const f = 1 / Math.tan(0.3), least = Math.min(width, height), near = 0.02 * distance, far = 6 * distance + 4;
    const rows = [right.map((v) => (v * f * least) / width), up.map((v) => (v * f * least) / height)];
    const A = (far + near) / (near - far), B = (2 * far * near) / (near - far);
    const z = [...back, -dot(back, eye)];
    const X = [...rows[0], -dot(rows[0], eye)], Y = [...rows[1], -dot(rows[1], eye)];
    const Z = z.map((v, k) => A * v + (k === 3 ? B : 0)), W = z.map((v) => -v);
    const matrix = new Float32Array(16);
    [X, Y, Z, W].forEach((row, r) => row.forEach((v, c) => { matrix[4 * c + r] = v; }));
    const project = ([x, y, zz]) => {
      const v = [X, Y, Z, W].map((row) => row[0] * x + row[1] * y + row[2] * zz + row[3]);
      return [(0.5 + (0.5 * v[0]) / v[3]) * width, (0.5 - (0.5 * v[1]) / v[3]) * height, v[3]];
    };
    return { matrix, eye, project, scale: (depth) => (0.5 * f * least) / depth };
  };

  // shapes: {kind, radius, length, frame, colour [r, g, b], flat}. floor: height at which a shadow falls, or null.
  const draw = (canvas, view, shapes, { floor = 0, shadow } = {}) => {
    const { width, height } = canvas, context = canvas.getContext("2d"), seen = camera(view, width, height);
    context.clearRect(0, 0, width, height);
    if (!begin()) { lines(context, seen, shapes); return seen; }
    const own = gl.canvas;
    if (own.width < width || own.height < height) [own.width, own.height] = [Math.max(own.width, width), Math.max(own.height, height)];
    gl.viewport(0, own.height - height, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(where.view, false, seen.matrix);
    gl.uniform3fv(where.eye, seen.eye);
    const one = (kind, model, colour, flat) => {
      const { buffer, count } = meshes[kind];
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.vertexAttribPointer(where.p, 3, gl.FLOAT, false, 24, 0);
      gl.vertexAttribPointer(where.n, 3, gl.FLOAT, false, 24, 12);
      gl.uniformMatrix4fv(where.model, false, model);
      gl.uniform4f(where.colour, colour[0] / 255, colour[1] / 255, colour[2] / 255, 1);
      gl.uniform1f(where.flat_, flat ? 1 : 0);
      gl.drawArrays(gl.TRIANGLES, 0, count);
    };
    const onFloor = floor !== null && shadow;
    for (const pass of onFloor ? ["shadow", "solid"] : ["solid"])
      for (const shape of shapes)
        for (const [kind, [R, p], size] of pieces(shape)) {
          if (pass === "shadow" && shape.flat) continue;
          const model = new Float32Array([R[0] * size[0], R[3] * size[0], R[6] * size[0], 0, R[1] * size[1], R[4] * size[1], R[7] * size[1], 0,
            R[2] * size[2], R[5] * size[2], R[8] * size[2], 0, ...p, 1]);
          if (pass === "shadow") for (const c of [0, 1, 2, 3]) model[4 * c + 2] = c === 3 ? floor + 0.0005 : 0;
          one(kind, model, pass === "shadow" ? shadow : shape.colour, pass === "shadow" || shape.flat);
        }
    context.drawImage(own, 0, 0, width, height, 0, 0, width, height);
    return seen;
  };

  // A shape as meshes: collision shapes have half-balls at their ends.
  const pieces = (shape) => {
    const { kind, radius, length, frame, round } = shape;
    if (kind === "sphere") return [["sphere", frame, [radius, radius, radius]]];
    const found = [["cylinder", frame, [radius, radius, length]]];
    if (round) for (const end of [-length / 2, length / 2]) found.push(["sphere", [frame[0], mobo.apply(frame, [0, 0, end])], [radius, radius, radius]]);
    return found;
  };

  const lines = (context, seen, shapes) => {
    const flat = shapes.map((shape) => {
      const h = (shape.length || 0) / 2, ends = [-h, h].map((z) => seen.project(mobo.apply(shape.frame, [0, 0, z])));
      return { ends, shape, depth: ends[0][2] + ends[1][2] };
    });
    for (const { ends, shape } of flat.sort((a, b) => b.depth - a.depth)) {
      context.strokeStyle = `rgb(${shape.colour.join(",")})`;
      context.lineWidth = Math.max(1, 2 * shape.radius * seen.scale(ends[0][2]));
      context.lineCap = shape.round ? "round" : "butt";
      context.beginPath();
      context.moveTo(ends[0][0], ends[0][1]);
      context.lineTo(ends[1][0] + 0.01, ends[1][1]);
      context.stroke();
    }
  };

  return { draw, webgl: () => !!begin() };
})();
