// Reads a USD file with tinyusdz (npm), which we did not write, and prints what it found: node read_usd.mjs FILE FOLDER,
// where FOLDER has node_modules/tinyusdz. That package is built for browsers: the few things of theirs that it asks for
// are put in place first.
import fs from 'fs';
const [file, folder] = process.argv.slice(2);
const wasm = fs.readFileSync(folder + '/node_modules/tinyusdz/tinyusdz.wasm');
globalThis.window = globalThis;
globalThis.fetch = async () => new Response(wasm, { headers: { 'Content-Type': 'application/wasm' } });
Object.defineProperty(process, 'versions', { value: {} });
const init = (await import(folder + '/node_modules/tinyusdz/tinyusdz.js')).default;
const module = await init({ wasmBinary: wasm });
const loader = new module.TinyUSDZLoaderNative();
const ok = loader.loadFromBinary(fs.readFileSync(file), 'shot.usda');
const meshes = [];
for (let i = 0; ok && i < loader.numMeshes(); ++i) {
  const mesh = loader.getMesh(i);
  meshes.push({ name: mesh.primName, points: mesh.points.length / 3, faces: mesh.faceVertexCounts.length, first: [...mesh.points.slice(0, 3)] });
}
console.log(JSON.stringify({ ok, meshes }));
