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
