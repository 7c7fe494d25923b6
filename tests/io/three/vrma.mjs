// What three-vrm-animation reads from a .vrma file: node vrma.mjs MODULES FILE
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, file] = process.argv.slice(2);
globalThis.self ??= globalThis;
const load = (path) => import(pathToFileURL(join(modules, path)).href);
const { GLTFLoader } = await load('three/examples/jsm/loaders/GLTFLoader.js');
const { VRMAnimationLoaderPlugin } = await load(
  '@pixiv/three-vrm-animation/lib/three-vrm-animation.module.js');

const loader = new GLTFLoader();
loader.register((parser) => new VRMAnimationLoaderPlugin(parser));
const data = readFileSync(file);
const buffer = data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength);
const [animation] = (await loader.parseAsync(buffer, '')).userData.vrmAnimations;
const tracks = (map) => Object.fromEntries(
  [...map].map(([bone, track]) => [bone, Array.from(track.values)]));
console.log(JSON.stringify({
  duration: animation.duration,
  hips: animation.restHipsPosition.toArray(),
  rotation: tracks(animation.humanoidTracks.rotation),
  translation: tracks(animation.humanoidTracks.translation),
}));
