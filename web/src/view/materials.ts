/**
 * How surfaces look: the light and the patterns of `batten render`, in one shader, so that the page and a picture of the
 * command line show the same. Colours are linear until the end.
 */
import { DataTexture, DoubleSide, FloatType, LinearFilter, RGBAFormat, ShaderMaterial, Vector3 } from 'three';

export type Shading = 'shaded' | 'isophotes' | 'reflection-lines' | 'normal-map' | 'values' | 'wireframe';
const MODES: Record<Shading, number> = {
  shaded: 0,
  isophotes: 1,
  'reflection-lines': 2,
  'normal-map': 3,
  values: 4,
  wireframe: 5,
};

const vertexShader = /* glsl */ `
attribute float value;
attribute vec3 corner;
varying vec3 vNormal;
varying vec3 vViewer;
varying float vValue;
varying vec3 vCorner;
void main() {
  vec4 place = modelViewMatrix * vec4(position, 1.0);
  vNormal = normalMatrix * normal;
  // Parallel rays have one viewer for all points.
  vViewer = isOrthographic ? vec3(0.0, 0.0, 1.0) : -place.xyz;
  vValue = value;
  vCorner = corner;
  gl_Position = projectionMatrix * place;
}`;

const fragmentShader = /* glsl */ `
precision highp float;
uniform int mode;
uniform bool flatShaded;
uniform float stripes;
uniform float low, high;
uniform vec3 up;
uniform sampler2D colours;
varying vec3 vNormal;
varying vec3 vViewer;
varying float vValue;
varying vec3 vCorner;

const float PI = 3.14159265358979;
const vec3 KEY = normalize(vec3(-0.42, 0.62, 0.66));
const vec3 FILL = normalize(vec3(0.85, 0.05, 0.52));
const vec3 BACK = normalize(vec3(0.1, 0.55, -0.83));

vec3 linear(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}
vec3 srgb(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
float wrapped(vec3 n, vec3 light, float wrap) {
  return max(0.0, (dot(n, light) + wrap) / (1.0 + wrap));
}
vec3 diffuse(vec3 n) {
  float sky = 0.5 + 0.5 * dot(n, up);
  vec3 light = (0.07 + 0.19 * sky) * vec3(0.94, 0.97, 1.0);
  light += 0.74 * wrapped(n, KEY, 0.10) * vec3(1.0, 0.975, 0.94);
  light += 0.17 * wrapped(n, FILL, 0.3) * vec3(0.90, 0.95, 1.0);
  light += 0.12 * wrapped(n, BACK, 0.1) * vec3(1.0);
  return light;
}
float specular(vec3 n, vec3 viewer, float shininess) {
  return pow(max(0.0, dot(n, normalize(KEY + viewer))), shininess);
}
vec3 matt(vec3 n, vec3 viewer, vec3 material) {
  float fresnel = pow(1.0 - max(0.0, dot(n, viewer)), 4.0);
  return 1.10 * diffuse(n) * material + vec3(0.06 * specular(n, viewer, 18.0) + 0.05 * specular(n, viewer, 90.0) + 0.06 * fresnel);
}
vec3 mapped(vec3 n, vec3 colour) {
  return (0.66 + 0.40 * diffuse(n).g) * colour;
}
/** How much of a pixel lies beyond an edge at 0, for a phase that changes by w over it: a box, as many samples give. */
float beyond(float phase, float w) {
  return clamp(phase / w + 0.5, 0.0, 1.0);
}
/** 1 on the first half of each stripe; slope is the change of the phase over one pixel along x and along y together. */
float stripe(float phase, float slope) {
  float w = clamp(slope, 0.0005, 1.0);
  float f = fract(phase);
  return beyond(f, w) * (1.0 - beyond(f - 0.5, w)) + beyond(f - 1.0, w);
}
void main() {
  vec3 viewer = normalize(vViewer);
  vec3 n = normalize(vNormal);
  vec3 flatNormal = normalize(cross(dFdx(-vViewer), dFdy(-vViewer)));
  bool inside = !gl_FrontFacing;
  if (flatShaded) n = flatNormal;
  else if (inside) n = -n;
  vec3 clay = linear(vec3(0.7647, 0.7922, 0.8392)), back = linear(vec3(0.7804, 0.6549, 0.5608));
  vec3 pale = linear(vec3(0.9137, 0.9216, 0.9333));
  vec3 colour;
  if (mode == 1) {
    vec3 light = normalize(vec3(-0.35, 0.50, 0.79));
    float phase = acos(clamp(dot(n, light), -1.0, 1.0)) / PI * stripes;
    float white = stripe(phase, fwidth(phase));
    colour = mapped(n, mix(linear(vec3(0.2039, 0.2314, 0.2784)), linear(vec3(0.9529, 0.9569, 0.9647)), white));
  } else if (mode == 2) {
    vec3 mirrored = 2.0 * dot(n, viewer) * n - viewer;
    vec3 axis = normalize(vec3(0.93, 0.12, 0.34));
    vec3 across = normalize(cross(axis, vec3(0.0, 0.0, 1.0)));
    vec3 along = cross(axis, across);
    float x = dot(mirrored, across), y = dot(mirrored, along);
    float phase = atan(x, y) / (2.0 * PI) * stripes;
    // The slope from x and y: that of the angle itself jumps where it goes round, and would draw a seam.
    float slope = (abs(y * dFdx(x) - x * dFdx(y)) + abs(y * dFdy(x) - x * dFdy(y))) / max(x * x + y * y, 1e-6) / (2.0 * PI) * stripes;
    float lamp = stripe(phase, slope);
    float fresnel = 0.25 + 0.75 * pow(1.0 - max(0.0, dot(n, viewer)), 3.0);
    colour = diffuse(n) * linear(vec3(0.2078, 0.3216, 0.4784)) + lamp * (0.55 + 0.3 * fresnel) * linear(vec3(0.9569, 0.9686, 0.9843));
  } else if (mode == 3) {
    float at = acos(clamp(dot(n, viewer), -1.0, 1.0)) / (PI / 2.0) * 9.0;
    float red = stripe(at, fwidth(at));
    float light = 0.78 + 0.22 * dot(n, vec3(-0.5, 0.7, 0.5));
    colour = light * mix(linear(vec3(0.1529, 0.2824, 0.6196)), linear(vec3(0.8235, 0.2039, 0.1804)), red);
  } else if (mode == 4) {
    float t = clamp((vValue - low) / max(high - low, 1e-30), 0.0, 1.0);
    vec3 ramp = texture2D(colours, vec2((t * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    bool known = vValue == vValue;
    colour = mapped(n, known ? ramp : linear(vec3(0.6039, 0.6275, 0.6588)));
  } else if (mode == 5) {
    vec3 w = fwidth(vCorner);
    vec3 a = smoothstep(vec3(0.0), 1.2 * w, vCorner);
    float line = 1.0 - min(min(a.x, a.y), a.z);
    colour = mix(matt(n, viewer, inside ? back : pale), linear(vec3(0.2, 0.2667, 0.3608)), 0.85 * line);
  } else {
    colour = matt(n, viewer, inside ? back : clay);
  }
  gl_FragColor = vec4(srgb(colour), 1.0);
}`;

/** A row of colours, linear, as a texture. */
export function colourTexture(rgb: Float32Array): DataTexture {
  const n = rgb.length / 3;
  const data = new Float32Array(4 * n);
  for (let i = 0; i < n; ++i) {
    data.set(rgb.subarray(3 * i, 3 * i + 3), 4 * i);
    data[4 * i + 3] = 1;
  }
  const texture = new DataTexture(data, n, 1, RGBAFormat, FloatType);
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

export function surfaceMaterial(): ShaderMaterial {
  return new ShaderMaterial({
    vertexShader,
    fragmentShader,
    side: DoubleSide,
    // Curves lie on the surface; a little behind itself, it does not cut them.
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
    uniforms: {
      mode: { value: 0 },
      flatShaded: { value: false },
      stripes: { value: 28 },
      low: { value: 0 },
      high: { value: 1 },
      up: { value: new Vector3(0, 1, 0) },
      colours: { value: null },
    },
  });
}

export function setShading(material: ShaderMaterial, shading: Shading): void {
  const uniform = material.uniforms.mode;
  if (uniform) uniform.value = MODES[shading];
}
