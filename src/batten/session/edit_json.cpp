#include "batten/session/edit_json.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

using Json = nlohmann::ordered_json;

/// A value in a sentence: as it stands where it is short. Nesting has no bound in JSON, so that what is
/// nested is not written out.
std::string shown(const Json& value) {
  constexpr size_t kMostShown = 8;
  if (!value.is_structured()) return value.dump().substr(0, 60);
  const bool flat = std::none_of(value.begin(), value.end(), [](const Json& x) { return x.is_structured(); });
  if (value.is_array() && flat && value.size() <= kMostShown) return value.dump().substr(0, 200);
  return value.is_array() ? concat("a list of ", value.size()) : std::string("an object");
}

/// The fields of one object, each to be taken once; what is left over is unknown.
class Fields {
 public:
  Fields(const Json& object, std::string what, std::vector<std::string> known)
      : object_(object), what_(std::move(what)) {
    std::string list;
    for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
    for (const auto& [name, value] : object.items())
      if (std::find(known.begin(), known.end(), name) == known.end())
        throw InvalidInput(concat(what_, " has no field \"", name, "\"; it takes ", list));
  }

  const Json* find(const std::string& name) const {
    const auto found = object_.find(name);
    return found == object_.end() ? nullptr : &*found;
  }
  const Json& require(const std::string& name) const {
    const Json* value = find(name);
    if (!value) throw InvalidInput(concat(what_, " needs the field \"", name, "\""));
    return *value;
  }
  [[noreturn]] void fail(const std::string& name, const std::string& expected) const {
    throw InvalidInput(concat("the field \"", name, "\" of ", what_, " must be ", expected));
  }

  double number(const std::string& name, double otherwise) const {
    const Json* value = find(name);
    return value ? number_of(*value, name) : otherwise;
  }
  double number_of(const Json& value, const std::string& name) const {
    if (!value.is_number()) fail(name, "a number");
    return value.get<double>();
  }
  bool flag(const std::string& name) const {
    const Json* value = find(name);
    if (value && !value->is_boolean()) fail(name, "true or false");
    return value && value->get<bool>();
  }
  int curve(const Json& value, const std::string& name) const {
    return id(value, name, 'c', "the id of a curve, such as \"c3\"");
  }
  int vertex(const Json& value, const std::string& name) const {
    return id(value, name, 'v', "the ids of vertices, such as [\"v3\", \"v5\"]");
  }
  int id(const Json& value, const std::string& name, char kind, const char* expected) const {
    const std::string text = value.is_string() ? value.get<std::string>() : "";
    long number = -1;
    if (text.size() < 2 || text[0] != kind || !parse_integer(std::string_view(text).substr(1), number) ||
        number < 0 || number > 2147483646)
      fail(name, expected);
    return static_cast<int>(number);
  }
  Points points(const Json& value, const std::string& name) const {
    if (!value.is_array()) fail(name, "a list of points [x, y, z]");
    Points points(static_cast<Eigen::Index>(value.size()), 3);
    for (size_t i = 0; i < value.size(); ++i) {
      const Json& point = value[i];
      if (!point.is_array() || point.size() != 3 ||
          !std::all_of(point.begin(), point.end(), [](const Json& x) { return x.is_number(); }))
        fail(name, concat("a list of points [x, y, z]; point ", i, " is ", shown(point)));
      for (size_t k = 0; k < 3; ++k)
        points(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = point[k].get<double>();
    }
    return points;
  }
  DrawnStroke stroke() const { return {points(require("points"), "points"), flag("closed")}; }
  DrawnStroke stroke_in(const Json& value, const std::string& name) const {
    if (!value.is_object()) fail(name, "an object {\"points\": …}");
    return Fields(value, concat("\"", name, "\" of ", what_), {"points", "closed"}).stroke();
  }
  InsertOptions options() const {
    InsertOptions options;
    options.snap = number("snap", 0);
    options.sharpness = number("sharpness", 0);
    if (const Json* into = find("into")) {
      const std::string text = into->is_string() ? into->get<std::string>() : "";
      if (text != "auto" && text != "face" && text != "opening")
        fail("into", "\"auto\", \"face\" or \"opening\"");
      options.into = text == "face" ? Into::Face : text == "opening" ? Into::Opening : Into::Auto;
    }
    return options;
  }

 private:
  const Json& object_;
  std::string what_;
};

Json list_of(const Points& points) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    list.push_back(Json::array({points(i, 0), points(i, 1), points(i, 2)}));
  return list;
}

std::string curve_id(int curve) {
  return concat("c", curve);
}

void put(Json& line, const DrawnStroke& stroke) {
  line["points"] = list_of(stroke.points);
  if (stroke.closed) line["closed"] = true;
}

Json object_of(const DrawnStroke& stroke) {
  Json object = Json::object();
  put(object, stroke);
  return object;
}

void put(Json& line, const InsertOptions& options) {
  if (options.snap != 0) line["snap"] = options.snap;
  if (options.sharpness != 0) line["sharpness"] = options.sharpness;
  if (options.into != Into::Auto) line["into"] = options.into == Into::Face ? "face" : "opening";
}

Json parsed_object(std::string_view text) {
  Json object;
  try {
    object = Json::parse(text);
  } catch (const Json::exception&) {
    throw InvalidInput(
        "the line is not JSON; expected one object such as {\"op\":\"undo\"} "
        "(numbers must be finite, without NaN)");
  }
  if (!object.is_object())
    throw InvalidInput("the line is not a JSON object; expected one such as {\"op\":\"undo\"}");
  return object;
}

Points axis_of(const Fields& fields, const Json& value) {
  Points axis = fields.points(value, "axis");
  if (axis.rows() != 2) fields.fail("axis", "two points [x, y, z]");
  return axis;
}

}  // namespace

std::string name_of_op(const Edit& edit) {
  constexpr const char* kNames[] = {"insert", "delete", "sharpness", "mirror", "hole", "glue",
                                    "skin",   "align",  "transform", "undo",   "redo"};
  return kNames[edit.index()];
}

std::string format_edit(const Edit& edit) {
  Json line = Json::object();
  line["op"] = name_of_op(edit);
  if (const auto* insert = std::get_if<InsertEdit>(&edit)) {
    put(line, insert->stroke);
    put(line, insert->options);
  } else if (const auto* deletion = std::get_if<DeleteEdit>(&edit)) {
    line["curve"] = curve_id(deletion->curve);
  } else if (const auto* sharpness = std::get_if<SharpnessEdit>(&edit)) {
    line["curve"] = curve_id(sharpness->curve);
    line["value"] = sharpness->value;
    if (sharpness->between)
      line["between"] = {concat("v", (*sharpness->between)[0]), concat("v", (*sharpness->between)[1])};
  } else if (const auto* mirror = std::get_if<MirrorEdit>(&edit)) {
    if (mirror->curve >= 0)
      line["curve"] = curve_id(mirror->curve);
    else
      put(line, mirror->stroke);
    if (mirror->axis) line["axis"] = list_of(*mirror->axis);
    put(line, mirror->options);
  } else if (const auto* hole = std::get_if<HoleEdit>(&edit)) {
    put(line, hole->stroke);
    put(line, hole->options);
  } else if (const auto* glue = std::get_if<GlueEdit>(&edit)) {
    line["first"] = object_of(glue->first);
    line["second"] = object_of(glue->second);
    if (glue->halves) line["halves"] = {curve_id((*glue->halves)[0]), curve_id((*glue->halves)[1])};
    put(line, glue->options);
  } else if (const auto* skin = std::get_if<SkinEdit>(&edit)) {
    line["profiles"] = Json::array();
    for (const DrawnStroke& profile : skin->profiles) line["profiles"].push_back(object_of(profile));
    line["spines"] = {object_of(skin->spines[0]), object_of(skin->spines[1])};
    put(line, skin->options);
  } else if (const auto* align = std::get_if<AlignEdit>(&edit)) {
    line["reference"] = curve_id(align->reference);
    put(line, align->stroke);
  } else if (const auto* transform = std::get_if<TransformEdit>(&edit)) {
    line["matrix"] = Json::array();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) line["matrix"].push_back(transform->matrix(i, j));
  }
  return line.dump();
}

Edit parse_edit(std::string_view text) {
  const Json line = parsed_object(text);
  const auto op_field = line.find("op");
  const std::string op = op_field != line.end() && op_field->is_string() ? op_field->get<std::string>() : "";
  const std::string what = "op " + op;
  if (op == "insert" || op == "hole") {
    const Fields fields(line, what, {"op", "points", "closed", "snap", "sharpness", "into"});
    if (op == "hole") return HoleEdit{fields.stroke(), fields.options()};
    return InsertEdit{fields.stroke(), fields.options()};
  }
  if (op == "delete") {
    const Fields fields(line, what, {"op", "curve"});
    return DeleteEdit{fields.curve(fields.require("curve"), "curve")};
  }
  if (op == "sharpness") {
    const Fields fields(line, what, {"op", "curve", "value", "between"});
    SharpnessEdit edit{fields.curve(fields.require("curve"), "curve"),
                       fields.number_of(fields.require("value"), "value"), std::nullopt};
    if (const Json* between = fields.find("between")) {
      if (!between->is_array() || between->size() != 2)
        fields.fail("between", "the ids of two vertices, such as [\"v3\", \"v5\"]");
      edit.between = {fields.vertex((*between)[0], "between"), fields.vertex((*between)[1], "between")};
    }
    return edit;
  }
  if (op == "mirror") {
    const Fields fields(line, what, {"op", "curve", "points", "axis", "snap", "sharpness", "into"});
    MirrorEdit edit;
    if (const Json* curve = fields.find("curve")) {
      if (fields.find("points")) throw InvalidInput("op mirror takes \"curve\" or \"points\", not both");
      edit.curve = fields.curve(*curve, "curve");
    } else if (const Json* points = fields.find("points")) {
      edit.stroke.points = fields.points(*points, "points");
    } else {
      throw InvalidInput("op mirror needs the field \"curve\" (or \"points\" for a new stroke)");
    }
    if (const Json* axis = fields.find("axis")) edit.axis = axis_of(fields, *axis);
    edit.options = fields.options();
    return edit;
  }
  if (op == "glue") {
    const Fields fields(line, what, {"op", "first", "second", "halves", "snap", "sharpness"});
    GlueEdit edit;
    edit.first = fields.stroke_in(fields.require("first"), "first");
    edit.second = fields.stroke_in(fields.require("second"), "second");
    if (const Json* halves = fields.find("halves")) {
      if (!halves->is_array() || halves->size() != 2)
        fields.fail("halves", "two ids of curves, such as [\"c4\", \"c7\"]");
      edit.halves = {fields.curve((*halves)[0], "halves"), fields.curve((*halves)[1], "halves")};
    }
    edit.options = fields.options();
    return edit;
  }
  if (op == "skin") {
    const Fields fields(line, what, {"op", "profiles", "spines", "snap", "sharpness"});
    SkinEdit edit;
    const Json &profiles = fields.require("profiles"), &spines = fields.require("spines");
    if (!profiles.is_array()) fields.fail("profiles", "a list of objects {\"points\": …}");
    for (const Json& profile : profiles) edit.profiles.push_back(fields.stroke_in(profile, "profiles"));
    if (!spines.is_array() || spines.size() != 2)
      fields.fail("spines", "a list of two objects {\"points\": …}");
    for (size_t k = 0; k < 2; ++k) edit.spines[k] = fields.stroke_in(spines[k], "spines");
    edit.options = fields.options();
    return edit;
  }
  if (op == "align") {
    const Fields fields(line, what, {"op", "reference", "points", "closed"});
    return AlignEdit{fields.curve(fields.require("reference"), "reference"), fields.stroke()};
  }
  if (op == "transform") {
    const Fields fields(line, what, {"op", "matrix"});
    const Json& matrix = fields.require("matrix");
    if (!matrix.is_array() || matrix.size() != 16) fields.fail("matrix", "16 numbers, row by row");
    TransformEdit edit;
    for (size_t k = 0; k < 16; ++k)
      edit.matrix(static_cast<int>(k / 4), static_cast<int>(k % 4)) = fields.number_of(matrix[k], "matrix");
    return edit;
  }
  if (op == "undo" || op == "redo") {
    const Fields fields(line, what, {"op"});
    if (op == "undo") return UndoEdit{};
    return RedoEdit{};
  }
  throw InvalidInput(
      concat(op.empty() ? std::string("the line has no \"op\"") : concat("there is no op \"", op, "\""),
             "; the ops are insert, delete, sharpness, mirror, hole, glue, skin, align, transform, undo, "
             "redo"));
}

bool is_whole_json(std::string_view text) {
  return Json::accept(text);
}

std::string format_session_header(const std::string& unit) {
  Json line = Json::object();
  line["batten_session"] = 1;
  line["unit"] = unit;
  return line.dump();
}

std::string parse_session_header(std::string_view text) {
  const std::string expected = R"(the first line of a session is {"batten_session":1,"unit":"m"})";
  Json line;
  try {
    line = Json::parse(text);
  } catch (const Json::exception&) {
    throw InvalidInput(expected);
  }
  if (!line.is_object() || !line.contains("batten_session")) throw InvalidInput(expected);
  if (line["batten_session"] != 1)
    throw InvalidInput(concat("this is version ", shown(line["batten_session"]),
                              " of the session format; version 1 is known"));
  const Fields fields(line, "the header", {"batten_session", "unit"});
  const Json* unit = fields.find("unit");
  if (!unit) return "m";
  if (!unit->is_string()) fields.fail("unit", "a text such as \"m\" or \"mm\"");
  return unit->get<std::string>();
}

}  // namespace batten
