// An arm as its URDF describes it: where its links are, which of them touch, and what its joints hold.
mobo.Robot = class {
  // text: a URDF that mobo made, a serial arm. Frames are [R (9, row by row), p (3)].
  constructor(text, tip = "") {
    const root = new DOMParser().parseFromString(text, "application/xml").documentElement;
    if (root.nodeName !== "robot") throw new Error("no robot");
    const kids = (node, name) => [...node.children].filter((child) => child.nodeName === name);
    const numbers = (text, otherwise) => (text ? text.trim().split(/\s+/).map(Number) : otherwise);
    const origin = (node) => {
      const at = node && kids(node, "origin")[0];
      return [mobo.fromRpy(numbers(at?.getAttribute("rpy"), [0, 0, 0])), numbers(at?.getAttribute("xyz"), [0, 0, 0])];
    };
    const shape = (node) => {
      const geometry = kids(node, "geometry")[0]?.firstElementChild, get = (name) => Number(geometry?.getAttribute(name));
      const material = kids(node, "material")[0]?.getAttribute("name") ?? "";
      if (geometry?.nodeName === "cylinder") return { kind: "cylinder", radius: get("radius"), length: get("length"), frame: origin(node), material };
      if (geometry?.nodeName === "sphere") return { kind: "sphere", radius: get("radius"), length: 0, frame: origin(node), material };
      return null;
    };
    const links = new Map(kids(root, "link").map((link) => {
      const inertial = kids(link, "inertial")[0];
      return [link.getAttribute("name"), {
        mass: Number(inertial && kids(inertial, "mass")[0]?.getAttribute("value")) || 0, com: origin(inertial)[1],
        visuals: kids(link, "visual").map(shape).filter(Boolean), collisions: kids(link, "collision").map(shape).filter(Boolean),
      }];
    }));
    const joints = kids(root, "joint").map((joint) => ({
      name: joint.getAttribute("name"), fixed: joint.getAttribute("type") === "fixed",
      slides: joint.getAttribute("type") === "prismatic", radius: Number(kids(joint, "slide")[0]?.getAttribute("radius") ?? 0.05),
      parent: kids(joint, "parent")[0].getAttribute("link"), child: kids(joint, "child")[0].getAttribute("link"),
      frame: origin(joint), axis: numbers(kids(joint, "axis")[0]?.getAttribute("xyz"), [1, 0, 0]),
      lower: Number(kids(joint, "limit")[0]?.getAttribute("lower") ?? -Math.PI),
      upper: Number(kids(joint, "limit")[0]?.getAttribute("upper") ?? Math.PI),
    }));
    const above = new Map(joints.map((joint) => [joint.child, joint])), parents = new Set(joints.map((joint) => joint.parent));
    this.tip = tip && links.has(tip) ? tip : [...links.keys()].filter((name) => !parents.has(name)).at(-1);
    const path = [];
    for (let link = this.tip; above.has(link); link = above.get(link).parent) path.unshift(above.get(link));
    this.path = path.map((joint) => ({ ...joint, link: links.get(joint.child) }));
    this.base = links.get(path.length ? path[0].parent : this.tip);
    this.moving = this.path.filter((joint) => !joint.fixed);
    this.n = this.moving.length;
    this.lower = this.moving.map((joint) => joint.lower);
    this.upper = this.moving.map((joint) => joint.upper);
    this.total = this.path.reduce((sum, joint) => sum + Math.hypot(...joint.frame[1]) + (joint.slides ? Math.max(Math.abs(joint.lower), Math.abs(joint.upper)) : 0), 0);
    const rest = this.lower.map((low, i) => Math.min(Math.max(0, low), this.upper[i]));
    this.pairs = this.#separate(rest);
  }

  // Frames of the links along the way (the base's first), with the number of joints that move each.
  place(q) {
    let frame = [[1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 0, 0]], i = 0;
    const placed = [{ link: this.base, frame, moved: 0 }];
    for (const joint of this.path) {
      frame = mobo.compose(frame, joint.frame);
      if (joint.slides) frame = [frame[0], mobo.apply(frame, joint.axis.map((a) => a * q[i]))];
      else if (!joint.fixed) frame = mobo.compose(frame, [mobo.turn(joint.axis, q[i]), [0, 0, 0]]);
      if (!joint.fixed) i++;
      placed.push({ link: joint.link, frame, moved: i, joint });
    }
    return placed;
  }

  capsules(placed) {
    return placed.flatMap(({ link, frame, moved }) => link.collisions.map((shape) => {
      const [R, p] = mobo.compose(frame, shape.frame), h = shape.length / 2, axis = [R[2], R[5], R[8]];
      return { moved, radius: shape.radius, a: p.map((v, k) => v - h * axis[k]), b: p.map((v, k) => v + h * axis[k]) };
    }));
  }

  // Pairs on different joints that do not touch in the straight arm: only these can collide.
  #separate(rest) {
    const found = this.capsules(this.place(rest)), pairs = [];
    for (let i = 0; i < found.length; i++)
      for (let j = i + 1; j < found.length; j++) {
        const a = found[i], b = found[j];
        if (a.moved !== b.moved && Math.sqrt(mobo.segmentDistance2(a.a, a.b, b.a, b.b)) - a.radius - b.radius > 1e-9) pairs.push([i, j]);
      }
    return pairs;
  }

  // Which collision shapes (by their place) touch or overlap another.
  colliding(placed) {
    const found = this.capsules(placed), hit = new Set();
    for (const [i, j] of this.pairs) {
      const a = found[i], b = found[j], reach = a.radius + b.radius;
      if (mobo.segmentDistance2(a.a, a.b, b.a, b.b) <= reach * reach) hit.add(i).add(j);
    }
    return hit;
  }

  // N m that hold each joint against gravity; the force of one that slides as the torque of its pinion.
  torques(placed, gravity, payload = 0) {
    const bodies = placed.map(({ link, frame, moved }) => ({ moved, mass: link.mass, at: mobo.apply(frame, link.com) }));
    bodies.push({ moved: this.n, mass: payload, at: placed.at(-1).frame[1] });
    return placed.filter(({ joint }) => joint && !joint.fixed).map(({ frame, joint, moved }) => {
      const axis = mobo.rotate(frame[0], joint.axis), origin = frame[1];
      let torque = 0;
      for (const body of bodies) {
        if (body.moved < moved || !body.mass) continue;
        const [x, y, z] = body.at.map((v, k) => v - origin[k]), [gx, gy, gz] = gravity.map((g) => g * body.mass);
        if (joint.slides) torque -= joint.radius * (axis[0] * gx + axis[1] * gy + axis[2] * gz);
        else torque -= axis[0] * (y * gz - z * gy) + axis[1] * (z * gx - x * gz) + axis[2] * (x * gy - y * gx);
      }
      return torque;
    });
  }
};

mobo.fromRpy = ([r, p, y]) => {
  const [cr, sr, cp, sp, cy, sy] = [Math.cos(r), Math.sin(r), Math.cos(p), Math.sin(p), Math.cos(y), Math.sin(y)];
  return [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, -sp, cp * sr, cp * cr];
};
mobo.turn = ([x, y, z], q) => { // Rodrigues' formula
  const c = Math.cos(q), s = Math.sin(q), t = 1 - c;
  return [t * x * x + c, t * x * y - s * z, t * x * z + s * y, t * x * y + s * z, t * y * y + c, t * y * z - s * x, t * x * z - s * y, t * y * z + s * x, t * z * z + c];
};
mobo.rotate = (R, [x, y, z]) => [R[0] * x + R[1] * y + R[2] * z, R[3] * x + R[4] * y + R[5] * z, R[6] * x + R[7] * y + R[8] * z];
mobo.apply = ([R, p], v) => mobo.rotate(R, v).map((w, k) => w + p[k]);
mobo.compose = ([R, p], [S, t]) => {
  const out = [];
  for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) out.push(R[3 * i] * S[j] + R[3 * i + 1] * S[3 + j] + R[3 * i + 2] * S[6 + j]);
  return [out, mobo.apply([R, p], t)];
};

// The squared distance of two segments (Ericson, Real-Time Collision Detection, section 5.1.9).
mobo.segmentDistance2 = (a0, a1, b0, b1) => {
  const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2], less = (u, v) => [u[0] - v[0], u[1] - v[1], u[2] - v[2]];
  const clamp = (x) => Math.min(Math.max(x, 0), 1);
  const u = less(a1, a0), v = less(b1, b0), w = less(a0, b0);
  const uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w), tiny = 1e-24;
  let s = 0, t = 0;
  if (uu <= tiny && vv > tiny) t = clamp(vw / vv);
  else if (uu > tiny && vv <= tiny) s = clamp(-uw / uu);
  else if (uu > tiny) {
    const det = uu * vv - uv * uv;
    s = uv * vw - uw * vv;
    s = clamp(det > 1e-14 * uu * vv ? s / det : s > 0 ? 1 : s);
    t = (uv * s + vw) / vv;
    if (t < 0) { t = 0; s = clamp(-uw / uu); } else if (t > 1) { t = 1; s = clamp((uv - uw) / uu); }
  }
  const d = w.map((x, k) => x + s * u[k] - t * v[k]);
  return dot(d, d);
};
