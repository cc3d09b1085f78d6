// What of freebody works in Pyodide, Python under WebAssembly, run by Node.js without a network:
//
//     node tools/browser.mjs PYODIDE SITE
//
// PYODIDE: a folder with the files of npm's `pyodide`, and beside them those wheels of Pyodide's
// that its pyodide-lock.json names for NumPy, SciPy, pandas and packaging.
// SITE: a folder with the packages of pure Python that freebody needs, and pytest, which the list
// of calls imports (pip install --no-deps --target), and Pyodide's wheel of python-flint, unpacked.
//
// Calls what `tests/support/without_llvm.py` lists; prints, as JSON, what fails and why.
import path from "node:path";
import { fileURLToPath } from "node:url";

const [pyodide, site] = process.argv.slice(2).map((given) => path.resolve(given));
const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "..");
const { loadPyodide } = await import(path.join(pyodide, "pyodide.mjs"));

const python = await loadPyodide({ indexURL: pyodide + path.sep });
await python.loadPackage(["numpy", "scipy", "pandas", "packaging"], { messageCallback() {} });
const places = { "/site": site, "/tests": path.join(root, "tests"), "/src": path.join(root, "src") };
for (const [place, folder] of Object.entries(places)) {
  python.FS.mkdir(place);
  python.FS.mount(python.FS.filesystems.NODEFS, { root: folder }, place);
}
python.globals.set("places", python.toPy(Object.keys(places)));
const failed = python.runPython(`
import json, os, sys, tempfile, warnings
sys.dont_write_bytecode = True
sys.path[:0] = places
warnings.simplefilter("ignore")
os.chdir(tempfile.mkdtemp())
from support.without_llvm import walked
found = walked()
json.dumps({"called": len(found), "failed": {k: v for k, v in found.items() if v}}, indent=1)
`);
console.log(failed);
