// From a recorded scan to a surface, with the library: reconstruct_scan scan.rawnet surface.ply
#include <cstdio>

#include "batten/core/error.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/surfacing/surface.hpp"

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: reconstruct_scan scan.rawnet surface.ply\n"), 2;
  try {
    const batten::Scan scan = batten::read_rawnet(argv[1]);
    const batten::ScanNetwork curves = batten::network_from_scan(scan);
    const batten::SurfaceResult surface = batten::surface_network(curves.network);
    batten::write_mesh(argv[2], surface.mesh);
    std::printf("%ld triangles over %d patches\n", static_cast<long>(surface.mesh.n_triangles()),
                surface.n_cycles);
  } catch (const batten::Error& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
