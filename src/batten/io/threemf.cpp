#include <map>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/mesh_formats_detail.hpp"
#include "batten/io/zip_archive.hpp"

namespace batten::detail {

// 3MF Core Specification 1.3: a zip file of a model in XML and of two files that say where it is.
std::string threemf_bytes(const TriangleMesh& mesh, double metres_per_unit) {
  constexpr double kMillimetres = 1000;
  std::string model =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<model unit=\"millimeter\" xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n"
      " <metadata name=\"Application\">Batten</metadata>\n"
      " <resources>\n  <object id=\"1\" type=\"model\">\n   <mesh>\n    <vertices>\n";
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    const char* const kAxes[] = {"x", "y", "z"};
    model += "     <vertex";
    for (int k = 0; k < 3; ++k)
      model += concat(" ", kAxes[k], "=\"",
                      exact_decimal(kMillimetres * metres_per_unit * mesh.positions(v, k)), "\"");
    model += "/>\n";
  }
  model += "    </vertices>\n    <triangles>\n";
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const int a = mesh.triangles(f, 0), b = mesh.triangles(f, 1), c = mesh.triangles(f, 2);
    if (a == b || b == c || c == a)
      throw InvalidInput(concat("3MF takes no face that names a vertex twice, as face ", f,
                                " does; mend the mesh with batten repair"));
    model += concat("     <triangle v1=\"", a, "\" v2=\"", b, "\" v3=\"", c, "\"/>\n");
  }
  model +=
      "    </triangles>\n   </mesh>\n  </object>\n </resources>\n <build>\n  <item objectid=\"1\"/>\n "
      "</build>\n"
      "</model>\n";
  const std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  return format_archive(
      {{"3D/3dmodel.model", std::move(model)},
       {"[Content_Types].xml",
        xml + "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n"
              " <Default Extension=\"rels\" "
              "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n"
              " <Default Extension=\"model\" "
              "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n"
              "</Types>\n"},
       {"_rels/.rels",
        xml + "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n"
              " <Relationship Id=\"rel0\" Target=\"/3D/3dmodel.model\" "
              "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>\n"
              "</Relationships>\n"}});
}

}  // namespace batten::detail
