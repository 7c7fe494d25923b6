// Where three.js sees joints: node positions.mjs MODULES FILE FRAMES RATE NAMES.json
// Prints [[frame][joint][x, y, z]] of the named joints, at frame / rate seconds.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, file, frames, rate, namesFile] = process.argv.slice(2);
globalThis.self ??= globalThis;
const load = (path) => import(pathToFileURL(join(modules, 'three', path)).href);
const THREE = await load('build/three.module.js');

async function parse() {
  if (file.toLowerCase().endsWith('.bvh')) {
    const { BVHLoader } = await load('examples/jsm/loaders/BVHLoader.js');
    const { skeleton, clip } = new BVHLoader().parse(readFileSync(file, 'utf8'));
    return { root: skeleton.bones[0], clip };
  }
  const { GLTFLoader } = await load('examples/jsm/loaders/GLTFLoader.js');
  const data = readFileSync(file);
  const buffer = data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength);
  const gltf = await new GLTFLoader().parseAsync(buffer, '');
  return { root: gltf.scene, clip: gltf.animations[0], parser: gltf.parser, gltf };
}

const { root, clip, gltf } = await parse();
const names = JSON.parse(readFileSync(namesFile, 'utf8'));
const found = new Map();
if (gltf) {
  // The loader cleans names; the file's own stand in its JSON, by node.
  for (const [object, link] of gltf.parser.associations) {
    if (link?.nodes !== undefined && object.isObject3D) {
      const name = gltf.parser.json.nodes[link.nodes].name;
      if (!found.has(name)) found.set(name, object);
    }
  }
} else {
  root.traverse((object) => found.has(object.name) || found.set(object.name, object));
}
const mixer = new THREE.AnimationMixer(root);
if (clip) {
  const action = mixer.clipAction(clip);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
}
const result = [];
for (let frame = 0; frame < Number(frames); frame++) {
  mixer.setTime(frame / Number(rate));
  root.updateMatrixWorld(true);
  result.push(names.map((name) => {
    const place = new THREE.Vector3().setFromMatrixPosition(found.get(name).matrixWorld);
    return [place.x, place.y, place.z];
  }));
}
console.log(JSON.stringify(result));
