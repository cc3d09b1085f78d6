// A number with so many digits, as `significant` of Python has it; in a title all of them stand. Loops are
// closed to 1e-12.
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
// A number with so many decimals, rounded as Python does: exactly between two it becomes the even one.
function decimals(value, count) {
  const text = value.toFixed(count), last = Number(text.at(-1));
  const between = last % 2 === 1 && /^\.?50*$/.test(value.toFixed(100).slice(text.length));
  return between ? text.slice(0, -1) + (last - 1) : text;
}
function significant(value, digits = 3) {
  if (!Number.isFinite(value)) return "no number";
  const [mantissa, power] = (Math.abs(value) < 1e-11 ? 0 : value).toExponential(digits - 1).split("e");
  const size = Number(power), signed = (text) => text.replace("-", "\u2212");
  if (Number(mantissa) === 0) return "0";
  if (size >= -3 && size < 5) return signed(decimals(value, Math.max(digits - 1 - size, 0)));
  return signed(mantissa) + "·10" + (size < 0 ? "⁻" : "") + [...String(Math.abs(size))].map((digit) => RAISED[digit]).join("");
}
// One of the numbers of a curve, with the decimals that its largest needs for as many digits.
function onCurve(value, largest, digits = 4) {
  const size = Math.floor(Math.log10(largest));
  if (!(size >= -3 && size < 5) || !Number.isFinite(value)) return significant(Math.abs(value) < 1e-6 * largest ? 0 : value, digits);
  const text = decimals(value, Math.max(digits - 1 - size, 0));
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
}
