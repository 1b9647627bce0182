// Evaluates the probes of `hemicube bake volume --for three` by three.js itself, and compares the irradiance along the six axes with
// that of `hemicube probe --volume` at the same samples. Called by run.sh.
import { readFileSync } from 'node:fs';
import { SphericalHarmonics3, Vector3, REVISION } from 'three';

const [probesFile, lightFile] = process.argv.slice(2);
const { probes } = JSON.parse(readFileSync(probesFile));
const light = JSON.parse(readFileSync(lightFile)).points;
const axes = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];

let worst = 0;
let largest = 0;
probes.forEach((numbers, sample) => {
  const sh = new SphericalHarmonics3().fromArray(numbers);
  axes.forEach((axis, i) => {
    const got = sh.getIrradianceAt(new Vector3(...axis), new Vector3());
    light[sample].irradiance[i].forEach((expected, channel) => {
      worst = Math.max(worst, Math.abs(Math.max(got.getComponent(channel), 0) - expected));
      largest = Math.max(largest, expected);
    });
  });
});
const share = worst / largest;
console.log(`three.js r${REVISION}: ${probes.length} probes, largest difference ${share.toExponential(1)} of the largest irradiance`);
// three.js rounds its constants to six digits.
process.exit(light.length === probes.length && largest > 0 && share < 1e-5 ? 0 : 1);
