/** A few poses of a clip, side by side, as stick figures. */

import { themed } from './colours.js';

const ONE = 1000;

/**
 * Draws poses into a canvas of its own size.
 * @param {HTMLCanvasElement} canvas
 * @param {Int16Array} strip right and up of each joint of each pose, thousandths of the body's height
 * @param {Int16Array} parents
 */
export function drawFilmstrip(canvas, strip, parents) {
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const [wide, high] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = wide * ratio;
  canvas.height = high * ratio;
  const paint = canvas.getContext('2d');
  paint.scale(ratio, ratio);
  const joints = parents.length;
  const poses = strip.length / (2 * joints);
  const scale = (high - 6) / ONE;
  paint.lineCap = 'round';
  paint.lineWidth = 1.4;
  paint.strokeStyle = themed('--text');
  for (let pose = 0; pose < poses; pose += 1) {
    const middle = ((pose + 0.5) * wide) / poses;
    const at = (joint) => {
      const k = 2 * (pose * joints + joint);
      return [middle + strip[k] * scale, high - 3 - strip[k + 1] * scale];
    };
    paint.globalAlpha = 0.55 + (0.45 * (pose + 1)) / poses;
    paint.beginPath();
    for (let joint = 1; joint < joints; joint += 1) {
      paint.moveTo(...at(parents[joint]));
      paint.lineTo(...at(joint));
    }
    paint.stroke();
  }
}
