// Joint values and controls as people read them.

const DEGREE = Math.PI / 180;
const FREE_SLIDE = 0.5; // m, of a slide without limits

function valueText(value, unit) {
  if (unit === "rad") return `${fixed(value / DEGREE, 1)}°`;
  if (unit === "m") return `${fixed(value * 1000, 1)} mm`;
  return unit ? `${shortNumber(value)} ${unit}` : shortNumber(value);
}

// With so many decimals, and no "-0".
function fixed(value, decimals) {
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

function shortNumber(value) {
  return fixed(value, Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 1 ? 2 : 3);
}

function massText(kilograms) {
  if (kilograms === null || kilograms === undefined) return "no mass";
  if (kilograms === 0) return "0 kg";
  return kilograms < 0.1 ? `${Number((kilograms * 1000).toPrecision(3))} g` : `${Number(kilograms.toPrecision(4))} kg`;
}

// The sliders of a joint: a hinge and a slide have one, a ball three, a free joint none. Each says its ends.
function jointSliders(joint) {
  if (joint.type === "free") return [];
  if (joint.type === "ball") {
    const reach = joint.range ? joint.range[1] : Math.PI;
    return ["x", "y", "z"].map((axis) => ({ label: `${joint.label} ${axis}`, low: -reach, high: reach, unit: "rad" }));
  }
  const unlimited = joint.type === "hinge" ? Math.PI : FREE_SLIDE;
  const [low, high] = joint.range ?? [joint.ref - unlimited, joint.ref + unlimited];
  return [{ label: joint.label, low, high, unit: joint.type === "hinge" ? "rad" : "m" }];
}

function actuatorSlider(actuator) {
  const [low, high] = actuator.range ?? (actuator.unit === "rad" ? [-Math.PI, Math.PI] : [-1, 1]);
  return { label: actuator.name, low, high, unit: actuator.unit };
}
