#include "batten/io/network_io.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/mesh_formats_detail.hpp"
#include "batten/io/network_formats_detail.hpp"
#include "batten/io/obj_detail.hpp"
#include "batten/io/standard_streams.hpp"

namespace batten {

namespace detail {

namespace {

constexpr long kMost = std::numeric_limits<int>::max() / 3;

Points to_points(const std::vector<double>& values) {
  return Eigen::Map<const Points>(values.data(), static_cast<Eigen::Index>(values.size() / 3), 3);
}

/// The next line that holds more than blanks and a comment; empty at the end of the file.
std::string_view next_content(LineReader& reader) {
  std::string_view line;
  while (reader.next(line)) {
    line = trim(without_comment(line));
    if (!line.empty()) return line;
  }
  return {};
}

/// One line: control characters would end it.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  return text;
}

/// Two-point lines joined into the longest chains that pass through vertices of degree 2 only. Drawing
/// programs write strokes so.
std::vector<NetworkCurve> joined_segments(const std::vector<NetworkCurve>& pieces, size_t n_vertices) {
  std::vector<int> degree(n_vertices, 0);
  for (const NetworkCurve& piece : pieces)
    for (const int v : piece.vertices) ++degree[static_cast<size_t>(v)];
  std::vector<std::array<int, 2>> at(n_vertices, {-1, -1});  // the pieces at vertices of degree 2
  for (size_t p = 0; p < pieces.size(); ++p)
    for (const int v : pieces[p].vertices)
      if (degree[static_cast<size_t>(v)] == 2)
        at[static_cast<size_t>(v)][at[static_cast<size_t>(v)][0] < 0 ? 0 : 1] = static_cast<int>(p);
  std::vector<char> taken(pieces.size(), 0);
  std::vector<NetworkCurve> curves;
  const auto walk = [&](size_t first, int from) {
    NetworkCurve curve = pieces[first];
    curve.vertices = {from};
    size_t piece = first;
    while (true) {
      taken[piece] = 1;
      const std::vector<int>& ends = pieces[piece].vertices;
      const int next = ends[0] == curve.vertices.back() ? ends[1] : ends[0];
      curve.vertices.push_back(next);
      if (degree[static_cast<size_t>(next)] != 2) break;
      const std::array<int, 2>& both = at[static_cast<size_t>(next)];
      const auto following = static_cast<size_t>(both[0] == static_cast<int>(piece) ? both[1] : both[0]);
      if (taken[following]) break;
      piece = following;
    }
    curves.push_back(std::move(curve));
  };
  for (size_t p = 0; p < pieces.size(); ++p)
    for (const int v : pieces[p].vertices)
      if (!taken[p] && degree[static_cast<size_t>(v)] != 2) walk(p, v);
  for (size_t p = 0; p < pieces.size(); ++p)  // what is left are closed chains
    if (!taken[p]) walk(p, pieces[p].vertices[0]);
  return curves;
}

}  // namespace

RawNetwork parse_net(std::string content, const std::string& path) {
  RawNetwork raw;
  const size_t size = content.size();
  LineReader reader(std::move(content), path);
  std::string_view line = next_content(reader);
  if (line.empty()) throw FileError(path, 0, "is empty, expected the number of vertices on the first line");
  Tokens header(line);
  const long n_vertices = read_integer(header, reader, "the number of vertices", 1, kMost);
  if (header.next(line))
    reader.fail("expected the number of vertices alone on the first line; is this a .net file?");
  if (static_cast<double>(n_vertices) * 6 > static_cast<double>(size) + 2)
    reader.fail(concat(n_vertices, " vertices do not fit into ", size,
                       " bytes; the file is truncated or its count is wrong"));
  std::vector<double> positions, normals;
  positions.reserve(3 * static_cast<size_t>(n_vertices));
  bool has_normals = false;
  for (long v = 0; v < n_vertices; ++v) {
    line = next_content(reader);
    if (line.empty())
      reader.fail(concat("the file ends after ", v, " of ", n_vertices,
                         " vertices; it is truncated or its count is wrong"));
    const std::vector<std::string_view> words = split_blanks(line);
    if (v == 0) has_normals = words.size() > 3;
    if (words.size() != (has_normals ? 6u : 3u))
      reader.fail(concat("vertex ", v, " has ", words.size(), " numbers, expected ",
                         has_normals ? "x y z nx ny nz" : "x y z"));
    Tokens tokens(line);
    for (int k = 0; k < 3; ++k) positions.push_back(read_finite(tokens, reader, "a coordinate"));
    if (has_normals)
      for (int k = 0; k < 3; ++k)
        normals.push_back(read_finite(tokens, reader, "a coordinate of the normal"));
  }
  line = next_content(reader);
  if (line.empty()) reader.fail("the file ends before the number of curves; it is truncated");
  Tokens count(line);
  const long n_curves = read_integer(count, reader, "the number of curves", 0, kMost);
  if (count.next(line))
    reader.fail(concat("expected the number of curves alone on this line; the file may hold more than the ",
                       n_vertices, " vertices announced"));
  for (long c = 0; c < n_curves; ++c) {
    NetworkCurve curve;
    line = next_content(reader);
    if (line.empty())
      reader.fail(concat("the file ends after ", c, " of ", n_curves,
                         " curves; it is truncated or its count is wrong"));
    Tokens flag(line);
    const long kind = read_integer(flag, reader, concat("the boundary flag of curve ", c), 0, 2);
    curve.boundary = kind == 1;
    curve.sharp = kind == 2;
    if (flag.next(line))
      reader.fail(concat("expected the boundary flag of curve ", c, " (0, 1 or 2) alone on this line"));
    line = next_content(reader);
    if (line.empty())
      reader.fail(concat("the file ends before the vertices of curve ", c, "; it is truncated"));
    std::string_view rest = line;
    Tokens tokens(rest);
    Tokens ahead = tokens;
    std::string_view word;
    while (ahead.next(word))
      curve.vertices.push_back(
          static_cast<int>(read_integer(tokens, reader, concat("a vertex of curve ", c), 0, n_vertices - 1)));
    if (curve.vertices.size() < 2)
      reader.fail(concat("curve ", c, " has fewer than two vertices; remove it"));
    raw.network.curves.push_back(std::move(curve));
  }
  line = next_content(reader);
  if (!line.empty())
    reader.fail(concat("more lines follow than the ", n_curves, " curves announced; correct the count"));
  raw.network.positions = to_points(positions);
  if (has_normals) raw.network.normals = to_points(normals);
  return raw;
}

RawNetwork parse_obj_network(std::string content, const std::string& path) {
  ObjContent obj = parse_obj(std::move(content), path);
  if (obj.lines.empty())
    throw FileError(path, 0,
                    obj.face_vertices.empty()
                        ? "holds no curves ('l a b c …')"
                        : "holds faces and no lines: it is a mesh, not a curve network");
  RawNetwork raw;
  raw.warnings = std::move(obj.warnings);
  CurveNetwork& network = raw.network;
  network.positions = to_points(obj.positions);
  const size_t n = obj.positions.size() / 3;
  bool ours = false;
  for (const std::string& comment : obj.comments) {
    const std::vector<std::string_view> words = split_blanks(comment);
    if (comment == "curve network") ours = true;
    if (!ours || words.empty()) continue;
    if (words[0] == "unit") network.unit = trim(std::string_view(comment).substr(4));
    if (words[0] == "nodes")
      for (size_t k = 1; k < words.size(); ++k) {
        long node = 0;
        if (!parse_integer(words[k], node) || node < 1 || node > static_cast<long>(n))
          throw FileError(
              path, 0, concat("the comment '# batten nodes' names vertex ", words[k], ", expected 1 to ", n));
        network.tagged_nodes.push_back(static_cast<int>(node - 1));
      }
  }
  if (obj.normals.size() == obj.positions.size())
    network.normals = to_points(obj.normals);
  else if (!obj.normals.empty())
    raw.warnings.push_back(concat(obj.normals.size() / 3, " normals for ", n,
                                  " vertices were left out; write one vn for each v"));
  std::vector<NetworkCurve> pieces;
  for (ObjContent::Line& line : obj.lines) {
    NetworkCurve curve{std::move(line.object), line.group == "boundary", std::move(line.vertices),
                       line.group == "sharp"};
    for (size_t k = 1; k < curve.vertices.size(); ++k)
      if (curve.vertices[k] == curve.vertices[k - 1])
        throw FileError(
            path, line.line,
            concat("vertex ", curve.vertices[k] + 1, " follows on itself; remove the repetition"));
    if (!ours && curve.vertices.size() == 2)
      pieces.push_back(std::move(curve));
    else
      network.curves.push_back(std::move(curve));
  }
  if (!pieces.empty()) {
    std::vector<NetworkCurve> curves = joined_segments(pieces, n);
    raw.warnings.push_back(
        concat(pieces.size(), " lines of two points were joined into ", curves.size(), " curves"));
    for (NetworkCurve& curve : curves) network.curves.push_back(std::move(curve));
  }
  if (!obj.face_vertices.empty())
    raw.warnings.push_back(concat(obj.face_offsets.size() - 1, " faces beside the lines were left out"));
  return raw;
}

std::string net_text(const CurveNetwork& network) {
  std::string text = concat(network.positions.rows(), '\n');
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v) {
    append_row(text, network.positions, v);
    if (network.has_normals()) append_row(text += ' ', network.normals, v);
    text += '\n';
  }
  text += concat(network.curves.size(), '\n');
  for (const NetworkCurve& curve : network.curves) {
    text += curve.boundary ? "1\n" : curve.sharp ? "2\n" : "0\n";
    for (size_t k = 0; k < curve.vertices.size(); ++k) {
      if (k > 0) text += ' ';
      text += std::to_string(curve.vertices[k]);
    }
    text += '\n';
  }
  return text;
}

std::string obj_network_text(const CurveNetwork& network) {
  std::string text = "# batten curve network\n";
  if (!network.unit.empty()) text += concat("# batten unit ", one_line(network.unit), '\n');
  constexpr size_t kPerLine = 20;
  for (size_t k = 0; k < network.tagged_nodes.size(); ++k) {
    text += k % kPerLine == 0 ? "# batten nodes " : " ";
    text += std::to_string(network.tagged_nodes[k] + 1);
    if (k % kPerLine == kPerLine - 1 || k + 1 == network.tagged_nodes.size()) text += '\n';
  }
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v) {
    append_row(text += "v ", network.positions, v);
    text += '\n';
  }
  if (network.has_normals())
    for (Eigen::Index v = 0; v < network.normals.rows(); ++v) {
      append_row(text += "vn ", network.normals, v);
      text += '\n';
    }
  for (const NetworkCurve& curve : network.curves) {
    text += concat("o ", one_line(curve.name), "\ng ",
                   curve.boundary ? "boundary"
                   : curve.sharp  ? "sharp"
                                  : "inner",
                   "\nl");
    for (const int v : curve.vertices) (text += ' ') += std::to_string(v + 1);
    text += '\n';
  }
  return text;
}

}  // namespace detail

namespace {

bool format_of_extension(const std::string& extension, NetworkFormat& format) {
  if (extension == "net")
    format = NetworkFormat::Net;
  else if (extension == "obj")
    format = NetworkFormat::Obj;
  else if (extension == "json")
    format = NetworkFormat::Json;
  else if (extension == "txt")
    format = NetworkFormat::CurveText;
  else if (extension == "lop")
    format = NetworkFormat::BSplines;
  else
    return false;
  return true;
}

/// Whether a line of an OBJ begins with the keyword of faces.
bool has_faces(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) ++at;
    if (at + 1 < text.size() && text[at] == 'f' && (text[at + 1] == ' ' || text[at + 1] == '\t')) return true;
    at = text.find('\n', at);
    if (at == std::string_view::npos) return false;
    ++at;
  }
  return false;
}

/// The format that the content shows beyond doubt; false when it could be several.
bool sniffed_format(std::string_view content, NetworkFormat& format) {
  if (content.substr(0, 3) == "\xEF\xBB\xBF") content.remove_prefix(3);
  const std::string_view text = trim(content.substr(0, 2000));
  detail::Tokens tokens(text);
  std::string_view first;
  if (!tokens.next(first)) return false;
  if (first[0] == '{')
    format = NetworkFormat::Json;
  else if (first == "CURVE")
    format = NetworkFormat::CurveText;
  else if (first == "v" || first == "o" || first == "g" || text.substr(0, 22) == "# batten curve network")
    format = NetworkFormat::Obj;
  else
    return false;
  return true;
}

const char* name_of(NetworkFormat format) {
  switch (format) {
    case NetworkFormat::Net:
      return ".net";
    case NetworkFormat::Obj:
      return "OBJ";
    case NetworkFormat::Json:
    case NetworkFormat::CurvesOnMesh:
      return "JSON";
    case NetworkFormat::CurveText:
      return "curve text";
    case NetworkFormat::BSplines:
      return ".lop";
  }
  return "";
}

/// What every reader's result must satisfy, whatever the format.
void check_result(CurveNetwork& network, const std::string& path) {
  if (network.curves.empty()) throw FileError(path, 0, "holds no curves");
  for (size_t c = 0; c < network.curves.size(); ++c) {
    const NetworkCurve& curve = network.curves[c];
    for (size_t k = 1; k < curve.vertices.size(); ++k)
      if (curve.vertices[k] == curve.vertices[k - 1])
        throw FileError(
            path, 0,
            concat("curve ", c, ": vertex ", curve.vertices[k], " follows on itself; remove the repetition"));
  }
  constexpr double kUnit = 1e-12;  // of the squared length; normals written by us stay as they are
  for (Eigen::Index v = 0; v < network.normals.rows(); ++v) {
    const double squared = network.normals.row(v).squaredNorm();
    if (!(squared > 0))
      throw FileError(
          path, 0,
          concat("vertex ", v, " has a normal of length 0; give it a direction or leave out all normals"));
    if (std::abs(squared - 1) > kUnit) network.normals.row(v) /= std::sqrt(squared);
  }
}

void check_arrays(const CurveNetwork& network) {
  const Eigen::Index n = network.positions.rows();
  if (network.normals.rows() != 0 && network.normals.rows() != n)
    throw InvalidInput(concat("the network has ", network.normals.rows(), " normals for ", n, " vertices"));
  for (size_t c = 0; c < network.curves.size(); ++c)
    for (const int v : network.curves[c].vertices)
      if (v < 0 || v >= n)
        throw InvalidInput(concat("curve ", c, " names vertex ", v, ", but there are ", n));
  for (const int v : network.tagged_nodes)
    if (v < 0 || v >= n) throw InvalidInput(concat("the node list names vertex ", v, ", but there are ", n));
}

/// The extension looks through .gz for the readers; what is written under such a name would be no gzip file.
void refuse_compressed(const std::string& path) {
  if (path.size() > 3 && path.compare(path.size() - 3, 3, ".gz") == 0)
    throw FileError(path, 0, "compressed files are read but not written; leave out .gz");
}

}  // namespace

bool holds_network(std::string_view extension, std::string_view content) {
  NetworkFormat format{};
  return format_of_extension(std::string(extension), format) &&
         (format != NetworkFormat::Obj || !has_faces(content));
}

NetworkFormat network_format(std::string_view path) {
  NetworkFormat format = NetworkFormat::Net;
  if (!format_of_extension(output_extension(path, "json"), format) || format == NetworkFormat::CurveText ||
      format == NetworkFormat::BSplines)
    throw UnknownExtension(path, "is no network file by its extension; use .net, .obj or .json");
  return format;
}

CurveNetwork parse_network(std::string content, const std::string& path, std::vector<std::string>* warnings) {
  if (content.empty()) throw FileError(path, 0, "is empty, expected a curve network");
  NetworkFormat by_content = NetworkFormat::Net, format = NetworkFormat::Net;
  const bool shown = sniffed_format(content, by_content);
  const std::string extension = path == "-" ? extension_of_content(content) : file_extension(path);
  const bool named = format_of_extension(extension, format);
  if (extension == "xyz")
    throw FileError(path, 0,
                    "holds points without order, from which no curves can be read; order them into a .txt "
                    "file with a line 'CURVE k' before each curve");
  if (!shown && !named)
    throw FileError(path, 0,
                    "is not recognised as a curve network; use a .net, .obj, .json, .txt or .lop file");
  std::vector<std::string> notes;
  if (shown && (!named || by_content != format)) {
    if (named)
      notes.push_back(concat(path, " is ", name_of(by_content), " by its content and was read as such"));
    format = by_content;
  }
  detail::RawNetwork raw;
  switch (format) {
    case NetworkFormat::Net:
      raw = detail::parse_net(std::move(content), path);
      break;
    case NetworkFormat::Obj:
      raw = detail::parse_obj_network(std::move(content), path);
      break;
    case NetworkFormat::Json:
    case NetworkFormat::CurvesOnMesh:
      raw = detail::parse_json_network(content, path);
      break;
    case NetworkFormat::CurveText:
      raw = detail::parse_curve_text(std::move(content), path);
      break;
    case NetworkFormat::BSplines:
      raw = detail::parse_bsplines(std::move(content), path);
      break;
  }
  check_result(raw.network, path);
  if (warnings != nullptr) {
    warnings->insert(warnings->end(), notes.begin(), notes.end());
    warnings->insert(warnings->end(), raw.warnings.begin(), raw.warnings.end());
  }
  return std::move(raw.network);
}

CurveNetwork read_network(const std::string& path, std::vector<std::string>* warnings) {
  return parse_network(read_file(path), path, warnings);
}

std::string format_network(const CurveNetwork& network, NetworkFormat format) {
  check_arrays(network);
  switch (format) {
    case NetworkFormat::Net:
      return detail::net_text(network);
    case NetworkFormat::Obj:
      return detail::obj_network_text(network);
    case NetworkFormat::Json:
      return detail::json_network_text(network);
    default:
      throw InvalidInput(
          concat("curve networks are not written as ", name_of(format), "; use .net, .obj or .json"));
  }
}

void write_network(const std::string& path, const CurveNetwork& network) {
  refuse_compressed(path);
  write_file(path, format_network(network, network_format(path)));
}

void write_uncertain_network(const std::string& path, const CurveNetwork& network,
                             const Eigen::VectorXd& uncertainty) {
  if (uncertainty.size() != network.positions.rows())
    throw InvalidInput(concat("there are ", uncertainty.size(), " deviations for ", network.positions.rows(),
                              " vertices of the network"));
  refuse_compressed(path);
  check_arrays(network);
  write_file(path, detail::json_network_text(network, uncertainty));
}

Eigen::VectorXd read_network_uncertainty(const std::string& path) {
  if (input_extension(path) != "json") return {};
  return detail::parse_json_uncertainty(read_file(path), path);
}

std::vector<std::string> losses_in_format(const CurveNetwork& network, NetworkFormat format) {
  std::vector<std::string> losses;
  if (format != NetworkFormat::Json &&
      std::any_of(network.curves.begin(), network.curves.end(),
                  [](const NetworkCurve& c) { return c.left_normals.rows() + c.right_normals.rows() > 0; }))
    losses.emplace_back("the normals on both sides of sharp curves are kept by .json alone");
  if (format != NetworkFormat::Net) return losses;
  if (std::any_of(network.curves.begin(), network.curves.end(),
                  [](const NetworkCurve& c) { return !c.name.empty(); }))
    losses.emplace_back(".net cannot hold the names of the curves; use .json to keep them");
  if (!network.tagged_nodes.empty())
    losses.emplace_back(
        ".net cannot hold the list of nodes, those that the curves show aside; use .json to keep it");
  if (!network.unit.empty())
    losses.push_back(concat(".net cannot hold the unit (", network.unit, "); use .json to keep it"));
  return losses;
}

}  // namespace batten
