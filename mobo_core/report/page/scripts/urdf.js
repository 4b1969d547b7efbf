// URDFs put together as mobo does it in Python, to the byte: the macros' texts, and numbers by the same operations.
mobo.urdf = (() => {
  // Python's str(float): the shortest decimal that reads back, its exponent below 1e-4 and from 1e16.
  const repr = (value) => {
    if (Object.is(value, -0)) return "-0.0";
    const size = Math.abs(value);
    if (value !== 0 && (size < 1e-4 || size >= 1e16)) {
      const [digits, power] = value.toExponential().split("e");
      return `${digits}e${power[0]}${power.slice(1).padStart(2, "0")}`;
    }
    const text = String(value);
    return text.includes(".") ? text : `${text}.0`;
  };

  const operations = {
    add: (a, b) => a + b, sub: (a, b) => a - b, mul: (a, b) => a * b, truediv: (a, b) => a / b,
    neg: (a) => -a, pos: (a) => a, abs: (a) => Math.abs(a), bool: (a) => a !== 0,
    lt: (a, b) => a < b, le: (a, b) => a <= b, gt: (a, b) => a > b, ge: (a, b) => a >= b,
    eq: (a, b) => a === b, ne: (a, b) => a !== b,
  };

  const filled = (ways, inputs) => {
    for (const way of ways ?? []) {
      const values = way.values.slice();
      inputs.forEach((value, i) => { values[i] = value; });
      const fits = way.steps.every(([name, a, b, target, expected]) => {
        const result = operations[name]?.(values[a], values[b]);
        if (result === undefined) return false;
        if (expected !== null) return result === expected;
        values[target] = result;
        return true;
      });
      if (fits) return way.texts.map((text, i) => (i ? repr(values[way.places[i - 1]]) + text : text)).join("");
    }
    return null;
  };

  const build = (template, joints, lengths, height = 0, tilt = 0, centers = []) => {
    if (!template) return null;
    const mounted = height !== 0 || tilt !== 0, m = mounted ? 1 : 0;
    const parts = [template.head.replaceAll(template.name, joints)];
    if (mounted) parts.push(filled(template.blocks[`mount:0:${m}`], [height, tilt]));
    let offset = 0;
    [...joints].forEach((joint, i) => {
      parts.push(filled(template.blocks[`${joint}:${i + 1}:${m}`], [offset, lengths[i], centers[i] ?? 0]));
      offset = lengths[i];
    });
    parts.push(filled(template.blocks[`tool:${joints.length}:${m}`], [offset]), template.tail);
    return parts.includes(null) ? null : parts.join("");
  };

  let table = null;
  const crc32 = (text) => {
    table ??= Uint32Array.from({ length: 256 }, (_, n) => {
      for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
      return n >>> 0;
    });
    let crc = 0xffffffff;
    for (const byte of new TextEncoder().encode(text)) crc = table[(crc ^ byte) & 255] ^ (crc >>> 8);
    return (crc ^ 0xffffffff) >>> 0;
  };

  // The recorded URDF of an arm, or null if this page cannot make it: its check sum says so.
  const of = async (study, row) => {
    study.template ??= mobo.unpack(mobo.json("urdf").text).then((data) => JSON.parse(new TextDecoder().decode(data)));
    const template = await study.template, raw = study.raw, base = study.meta.base;
    const text = template.verbatim?.[row]
      ?? build(template.parts, study.order(row), study.lengths(row), raw.base_height?.[row] ?? base.height, raw.base_tilt?.[row] ?? base.tilt,
        study.meta.centers.map((center, i) => raw[`joint_center_${i + 1}`]?.[row] ?? center));
    return text !== null && crc32(text) === raw.crc[row] ? text : null;
  };
  return { repr, build, crc32, of };
})();
