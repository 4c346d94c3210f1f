#include "batten/io/rig_io.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/json_reader_detail.hpp"

namespace batten {

namespace {

using detail::JsonReader;
using OrderedJson = JsonReader::Json;

constexpr const char* kRigFormat = "batten rig";
constexpr int kRigVersion = 1;

struct CameraNumber {
  const char* name;
  double Camera::*number;
};
constexpr CameraNumber kNumbers[] = {{"fx", &Camera::fx}, {"fy", &Camera::fy}, {"cx", &Camera::cx},
                                     {"cy", &Camera::cy}, {"k1", &Camera::k1}, {"k2", &Camera::k2},
                                     {"k3", &Camera::k3}, {"p1", &Camera::p1}, {"p2", &Camera::p2}};

OrderedJson numbers_json(const Camera& camera) {
  OrderedJson json = OrderedJson::object();
  for (const CameraNumber& each : kNumbers) json[each.name] = camera.*each.number;
  return json;
}

OrderedJson camera_json(const Camera& camera) {
  OrderedJson json = {{"width", camera.width}, {"height", camera.height}};
  json.update(numbers_json(camera));
  return json;
}

Camera read_numbers(const JsonReader& reader, const OrderedJson& object, const std::string& where) {
  Camera camera;
  for (const CameraNumber& each : kNumbers) camera.*each.number = reader.number(object, each.name, where);
  return camera;
}

Camera read_camera(const JsonReader& reader, const OrderedJson& document, const std::string& side) {
  const OrderedJson& object = reader.member(document, side, "");
  const std::string where = side + ".";
  Camera camera = read_numbers(reader, object, where);
  camera.width = reader.count(object, "width", where);
  camera.height = reader.count(object, "height", where);
  return camera;
}

struct FigureNumber {
  const char* name;
  double RigFigures::*number;
};
constexpr FigureNumber kFigures[] = {{"left_rms_px", &RigFigures::left_rms},
                                     {"right_rms_px", &RigFigures::right_rms},
                                     {"rms_px", &RigFigures::rms},
                                     {"epipolar_px", &RigFigures::epipolar},
                                     {"epipolar_rms_px", &RigFigures::epipolar_rms},
                                     {"held_back_px", &RigFigures::held_back},
                                     {"left_coverage", &RigFigures::left_coverage},
                                     {"right_coverage", &RigFigures::right_coverage}};

OrderedJson figures_json(const RigFigures& figures) {
  OrderedJson json = {{"board",
                       {{"columns", figures.board.columns},
                        {"rows", figures.board.rows},
                        {"square_m", figures.board.square}}},
                      {"lens", word_of(figures.lens)},
                      {"pairs", figures.pairs},
                      {"corners", figures.corners},
                      {"left_out", figures.left_out}};
  for (const FigureNumber& each : kFigures) json[each.name] = figures.*each.number;
  json["tilt_rad"] = figures.tilt;
  const RigDeviations& deviations = figures.deviations;
  json["standard_deviations"] = {{"left", numbers_json(deviations.left)},
                                 {"right", numbers_json(deviations.right)},
                                 {"rotation_rad", JsonReader::list(deviations.rotation)},
                                 {"translation_m", JsonReader::list(deviations.translation)}};
  return json;
}

RigFigures read_figures(const JsonReader& reader, const OrderedJson& object) {
  const std::string where = "calibration.";
  RigFigures figures;
  const OrderedJson& board = reader.member(object, "board", where);
  figures.board.columns = reader.count(board, "columns", where + "board.");
  figures.board.rows = reader.count(board, "rows", where + "board.");
  figures.board.square = reader.number(board, "square_m", where + "board.");
  if (const auto found = figures.board.problem()) reader.fail(concat("calibration.board: ", *found));
  const OrderedJson& lens = reader.member(object, "lens", where);
  try {
    figures.lens = parse_choice<LensModel>(lens.is_string() ? lens.get<std::string>() : lens.dump());
  } catch (const InvalidInput& error) {
    reader.fail(concat("calibration.lens: ", error.what()));
  } catch (const nlohmann::json::exception&) {  // bytes that are no UTF-8
    reader.fail("calibration.lens is no text");
  }
  figures.pairs = reader.count(object, "pairs", where);
  figures.corners = reader.count(object, "corners", where);
  figures.left_out = reader.count(object, "left_out", where);
  for (const FigureNumber& each : kFigures) figures.*each.number = reader.number(object, each.name, where);
  figures.tilt = reader.number(object, "tilt_rad", where);
  const OrderedJson& deviations = reader.member(object, "standard_deviations", where);
  const std::string inside = where + "standard_deviations.";
  figures.deviations.left = read_numbers(reader, reader.member(deviations, "left", inside), inside + "left.");
  figures.deviations.right =
      read_numbers(reader, reader.member(deviations, "right", inside), inside + "right.");
  figures.deviations.rotation =
      reader.vector(reader.member(deviations, "rotation_rad", inside), inside + "rotation_rad");
  figures.deviations.translation =
      reader.vector(reader.member(deviations, "translation_m", inside), inside + "translation_m");
  return figures;
}

}  // namespace

CalibratedRig read_rig(const std::string& path) {
  return parse_rig(read_file(path), path);
}

CalibratedRig parse_rig(const std::string& text, const std::string& name) {
  const JsonReader reader(name, "write the file with batten rig calibrate");
  const OrderedJson document = reader.parse(text);
  if (!document.is_object() || document.value("format", OrderedJson()) != kRigFormat)
    reader.fail("is no stereo rig: expected \"format\": \"batten rig\"; write it with batten rig calibrate");
  if (const int version = reader.count(document, "version", ""); version > kRigVersion)
    reader.fail(concat("is a rig of version ", version, ", this program knows up to ", kRigVersion,
                       "; use a newer batten, or calibrate again"));
  CalibratedRig result;
  result.rig.left = read_camera(reader, document, "left");
  result.rig.right = read_camera(reader, document, "right");
  result.rig.rotation = reader.matrix(reader.member(document, "rotation", ""), "rotation");
  result.rig.translation = reader.vector(reader.member(document, "translation_m", ""), "translation_m");
  if (const std::string found = problem(result.rig); !found.empty())
    reader.fail(concat(found, "; calibrate again"));
  if (document.contains("calibration")) result.figures = read_figures(reader, document.at("calibration"));
  return result;
}

void write_rig(const CalibratedRig& rig, const std::string& path) {
  if (const std::string found = problem(rig.rig); !found.empty()) throw InvalidInput(found);
  OrderedJson document = {
      {"format", kRigFormat},
      {"version", kRigVersion},
      {"meaning",
       "X_right = rotation X_left + translation, metres; x right, y down, z forward; the centre "
       "of the first pixel is (0.5, 0.5)"}};
  document["left"] = camera_json(rig.rig.left);
  document["right"] = camera_json(rig.rig.right);
  document["rotation"] = JsonReader::list(rig.rig.rotation);
  document["translation_m"] = JsonReader::list(rig.rig.translation);
  if (rig.figures.pairs > 0) document["calibration"] = figures_json(rig.figures);
  write_file(path, document.dump(2) + "\n");
}

}  // namespace batten
