/** Colours: the palette that stays apart for the colour-blind, and the two themes of the stage. */

/** Okabe and Ito's colours by the names that shows use. */
export const PALETTE = {
  blue: '#0072B2', orange: '#E69F00', green: '#009E73', purple: '#CC79A7',
  red: '#D55E00', yellow: '#F0E442', sky: '#56B4E9', grey: '#8A9099',
};

/** Red, green and blue, 0 … 1, as the screen shows them. */
export function rgb(name) {
  const code = PALETTE[name] ?? PALETTE.grey;
  return [1, 3, 5].map((at) => parseInt(code.slice(at, at + 2), 16) / 255);
}

const shade = (code) => [1, 3, 5].map((at) => parseInt(code.slice(at, at + 2), 16) / 255);

/** What the floor, its lines, the background and the light look like, light and dark. */
export const THEMES = {
  light: {
    floor: shade('#E6E9ED'), fine: shade('#DADFE4'), metre: shade('#BDC5CD'),
    haze: shade('#F6F7F9'), above: shade('#E6EBF1'),
    sky: 0.54, ground: 0.22, sun: 0.84, shadow: 0.34,
    text: '#1D2329', plate: 'rgba(255,255,255,0.88)', edge: 'rgba(0,0,0,0.14)',
  },
  dark: {
    floor: shade('#23282E'), fine: shade('#2A3037'), metre: shade('#3D454E'),
    haze: shade('#15181C'), above: shade('#1D2228'),
    sky: 0.46, ground: 0.18, sun: 0.86, shadow: 0.46,
    text: '#E8ECF0', plate: 'rgba(28,33,38,0.88)', edge: 'rgba(255,255,255,0.16)',
  },
};
