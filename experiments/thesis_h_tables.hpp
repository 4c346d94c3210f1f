#pragma once

// The tables of H chapter 2 as printed.
namespace batten::experiments {

/// H Table 2.1: counts and volumes of the meshes, and the noise c1, c2 of (2.36) put on them.
struct MeshData {
  const char* mesh;
  long n_vertices;
  double volume;
  double c1, c2;
};
inline constexpr MeshData kTable21[] = {{"fandisk", 25894, 0.234024, -0.6, -0.6},
                                        {"oilpump", 41090, 0.184494, -0.8, -0.8},
                                        {"igea", 134345, 0.376882, 0.8, 0.8}};

/// H Table 2.2: time step τ, iterations, ΔV "%", and σ of (2.30), 0 for none.
struct FairingRow {
  const char *mesh, *algorithm;
  double time_step;
  int iterations;
  double volume_change, similarity;
};
inline constexpr FairingRow kTable22[] = {
    {"fandisk", "MCF", 0.013, 10, 8.11e-4, 0},      {"fandisk", "SDF", 0.139, 10, 0.89e-4, 0},
    {"fandisk", "NL-SDF", 0.139, 10, 0.92e-4, 0.6}, {"oilpump", "MCF", 0.013, 10, 5.93e-4, 0},
    {"oilpump", "SDF", 0.077, 10, 0.32e-4, 0},      {"oilpump", "NL-SDF", 0.022, 10, 0.32e-4, 0.5},
    {"igea", "MCF", 0.146, 20, 3.90e-4, 0},         {"igea", "SDF", 0.141, 20, 0.02e-4, 0},
    {"igea", "NL-SDF", 0.141, 20, 0.02e-4, 0.6}};

/// H Table 2.3: iterations; ΔH, ΔVar(E), ΔVar(A), ΔVar(H) in per cent; one-sided mean distance.
struct RemeshRow {
  const char *mesh, *method;
  int iterations;
  double curvature, edges, areas, curvature_variance, distance;
};
inline constexpr RemeshRow kTable23[] = {{"hand", "AR", 5, 17.8, 77.2, 61.2, 5.9, 0.002},
                                         {"hand", "LF", 5, 40.3, 78.4, 51.6, 47.1, 0.003},
                                         {"gargoyle", "AR", 10, 26.4, 63.7, 47.5, 14.3, 0.007},
                                         {"gargoyle", "LF", 10, 69.0, 81.6, 48.0, 59.7, 0.016},
                                         {"fandisk", "AR", 20, 4.7, 51.7, 55.2, 0.8, 0.005},
                                         {"fandisk", "LF", 20, 30.3, 74.4, 31.0, 5.9, 0.013},
                                         {"igea", "AR", 20, 12.9, 57.3, 41.4, 5.2, 0.004},
                                         {"igea", "LF", 20, 27.5, 64.9, 41.5, 34.3, 0.005},
                                         {"foot", "AR", 10, 13.1, 92.8, 65.4, 3.7, 0.007},
                                         {"foot", "LF", 10, 28.2, 93.0, 62.7, 22.5, 0.008}};

/// H Tables 2.4 and 2.5: share removed in per cent; dmax, dmean, dRMS (2.102–2.104) of MeshLab and of H.
struct SimplifyRow {
  const char* mesh;
  double removed;
  double meshlab[3], thesis[3];
};
inline constexpr SimplifyRow kTable24[] = {
    {"cube-hole", 80, {0.451881, 0.020130, 0.057686}, {0.041205, 0.000515, 0.001484}},
    {"cube-hole", 90, {0.312231, 0.008965, 0.032611}, {0.021760, 0.000822, 0.001798}},
    {"cube-hole", 95, {0.418654, 0.015544, 0.046249}, {0.014150, 0.000815, 0.001572}},
    {"cube-hole", 97, {0.522198, 0.019978, 0.060159}, {0.009750, 0.000937, 0.001454}},
    {"fandisk", 80, {0.052219, 0.000163, 0.001662}, {0.007219, 0.000331, 0.000728}},
    {"fandisk", 90, {0.054350, 0.000450, 0.003027}, {0.007670, 0.000505, 0.000976}},
    {"fandisk", 95, {0.054343, 0.000536, 0.002795}, {0.013716, 0.000855, 0.001540}},
    {"fandisk", 97, {0.098489, 0.001068, 0.006474}, {0.020589, 0.001210, 0.002178}},
    {"mechpart", 80, {0.004266, 0.000380, 0.000633}, {0.011192, 0.001768, 0.002482}},
    {"mechpart", 90, {0.010306, 0.001085, 0.001842}, {0.021135, 0.003309, 0.005000}},
    {"mechpart", 95, {0.026714, 0.003438, 0.005651}, {0.036440, 0.005390, 0.008207}},
    {"mechpart", 97, {0.083372, 0.011076, 0.017769}, {0.068840, 0.010379, 0.016617}}};
inline constexpr SimplifyRow kTable25[] = {
    {"horse", 99, {0.028324, 0.002269, 0.003014}, {0.023522, 0.002283, 0.002976}},
    {"horse", 99.9, {0.161733, 0.018871, 0.027483}, {0.161740, 0.020073, 0.027316}},
    {"dinosaur", 99, {0.022501, 0.003289, 0.004312}, {0.018831, 0.003295, 0.004232}},
    {"dinosaur", 99.9, {0.125394, 0.018922, 0.024967}, {0.134250, 0.018896, 0.025031}},
    {"foot", 99, {0.023356, 0.003518, 0.004635}, {0.017761, 0.003127, 0.004170}},
    {"foot", 99.9, {0.110770, 0.024386, 0.031521}, {0.090827, 0.025222, 0.030887}},
    {"hand", 99, {0.015215, 0.002073, 0.002715}, {0.017967, 0.001979, 0.002536}},
    {"hand", 99.9, {0.121775, 0.017971, 0.024672}, {0.085372, 0.017085, 0.022208}},
    {"igea", 99, {0.012795, 0.001324, 0.001753}, {0.011045, 0.001340, 0.001759}},
    {"igea", 99.9, {0.046810, 0.008417, 0.010807}, {0.042718, 0.008091, 0.010267}}};

}  // namespace batten::experiments
