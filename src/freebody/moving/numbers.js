// A number with so many digits, as `significant` of Python has it; in a title all of them stand. Loops are
// closed to 1e-12.
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
function significant(value, digits = 3) {
  if (!Number.isFinite(value)) return "no number";
  const [mantissa, power] = (Math.abs(value) < 1e-11 ? 0 : value).toExponential(digits - 1).split("e");
  const size = Number(power), signed = (text) => text.replace("-", "\u2212");
  if (Number(mantissa) === 0) return "0";
  if (size >= -3 && size < 5) return signed(value.toFixed(Math.max(digits - 1 - size, 0)));
  return signed(mantissa) + "·10" + (size < 0 ? "⁻" : "") + [...String(Math.abs(size))].map((digit) => RAISED[digit]).join("");
}
// One of the numbers of a curve, with the decimals that its largest needs for as many digits.
function onCurve(value, largest, digits = 4) {
  const size = Math.floor(Math.log10(largest));
  if (!(size >= -3 && size < 5) || !Number.isFinite(value)) return significant(Math.abs(value) < 1e-6 * largest ? 0 : value, digits);
  const text = value.toFixed(Math.max(digits - 1 - size, 0));
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
}
