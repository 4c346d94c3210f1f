#include <map>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/session/json_fields_detail.hpp"
#include "batten/session/sketch_edit_json_detail.hpp"

namespace batten::detail {

namespace {

constexpr auto into_words(Into) {
  return choices<Into>("side", {{Into::Auto, "auto"}, {Into::Face, "face"}, {Into::Opening, "opening"}});
}

void put(Json& line, const DrawnStroke& stroke) {
  line.add("points", list_of_points(stroke.points));
  if (stroke.closed) line.add("closed", true);
}

Json object_of(const DrawnStroke& stroke) {
  Json object;
  put(object, stroke);
  return object;
}

void put(Json& line, const InsertOptions& options) {
  if (options.snap != 0) line.add("snap", options.snap);
  if (options.sharpness != 0) line.add("sharpness", options.sharpness);
  if (options.into != Into::Auto) line.add("into", into_words(options.into).word(options.into));
}

Json pair_of_ids(char kind, const std::array<int, 2>& ids) {
  return Json::List{id_text(kind, ids[0]), id_text(kind, ids[1])};
}

void put_edit(Json& line, const InsertEdit& edit) {
  put(line, edit.stroke);
  put(line, edit.options);
}
void put_edit(Json& line, const DeleteEdit& edit) {
  line.add("curve", id_text('c', edit.curve));
}
void put_edit(Json& line, const SharpnessEdit& edit) {
  line.add("curve", id_text('c', edit.curve));
  line.add("value", edit.value);
  if (edit.between) line.add("between", pair_of_ids('v', *edit.between));
}
void put_edit(Json& line, const MirrorEdit& edit) {
  if (edit.curve >= 0)
    line.add("curve", id_text('c', edit.curve));
  else
    put(line, edit.stroke);
  if (edit.axis) line.add("axis", list_of_points(*edit.axis));
  put(line, edit.options);
}
void put_edit(Json& line, const HoleEdit& edit) {
  put(line, edit.stroke);
  put(line, edit.options);
}
void put_edit(Json& line, const GlueEdit& edit) {
  line.add("first", object_of(edit.first));
  line.add("second", object_of(edit.second));
  if (edit.halves) line.add("halves", pair_of_ids('c', *edit.halves));
  put(line, edit.options);
}
void put_edit(Json& line, const SkinEdit& edit) {
  Json::List profiles;
  for (const DrawnStroke& profile : edit.profiles) profiles.push_back(object_of(profile));
  line.add("profiles", std::move(profiles));
  line.add("spines", Json::List{object_of(edit.spines[0]), object_of(edit.spines[1])});
  put(line, edit.options);
}
void put_edit(Json& line, const AlignEdit& edit) {
  line.add("reference", id_text('c', edit.reference));
  put(line, edit.stroke);
}
void put_edit(Json& line, const TransformEdit& edit) {
  Json::Numbers matrix;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) matrix.push_back(edit.matrix(i, j));
  line.add("matrix", std::move(matrix));
}

DrawnStroke stroke_of(const Fields& fields) {
  return {fields.points(fields.require("points"), "points"), fields.flag("closed")};
}

DrawnStroke stroke_in(const Fields& fields, const Json& value, const std::string& name) {
  if (!value.get<Json::Object>()) fields.fail(name, "an object {\"points\": …}");
  return stroke_of(Fields(value, concat("\"", name, "\" of ", fields.what()), {"points", "closed"}));
}

InsertOptions options_of(const Fields& fields) {
  InsertOptions options;
  const Json* snap = fields.find("snap");
  const auto* how = snap ? snap->get<std::string>() : nullptr;
  if (how && *how != "auto") fields.fail("snap", "a length, or \"auto\"");
  if (!how) options.snap = fields.number("snap", 0);
  options.sharpness = fields.number("sharpness", 0);
  if (const Json* into = fields.find("into")) {
    const auto* word = into->get<std::string>();
    const auto found = into_words(Into::Auto).find(word ? *word : "");
    if (!found) fields.fail("into", "\"auto\", \"face\" or \"opening\"");
    options.into = *found;
  }
  return options;
}

std::array<int, 2> curves_of(const Fields& fields, const Json& value, const char* name) {
  if (!value.is_list() || value.size() != 2) fields.fail(name, "two ids of curves, such as [\"c4\", \"c7\"]");
  return {fields.curve(value.at(0), name), fields.curve(value.at(1), name)};
}

SketchEdit sharpness_of(const Fields& fields) {
  SharpnessEdit edit{fields.curve(fields.require("curve"), "curve"),
                     fields.number_of(fields.require("value"), "value"), std::nullopt};
  if (const Json* between = fields.find("between")) {
    if (!between->is_list() || between->size() != 2)
      fields.fail("between", "the ids of two vertices, such as [\"v3\", \"v5\"]");
    edit.between = {fields.vertex(between->at(0), "between"), fields.vertex(between->at(1), "between")};
  }
  return edit;
}

SketchEdit mirror_of(const Fields& fields) {
  MirrorEdit edit;
  if (const Json* curve = fields.find("curve")) {
    if (fields.find("points")) throw InvalidInput("op mirror takes \"curve\" or \"points\", not both");
    edit.curve = fields.curve(*curve, "curve");
  } else if (fields.find("points")) {
    edit.stroke = stroke_of(fields);
  } else {
    throw InvalidInput("op mirror needs the field \"curve\" (or \"points\" for a new stroke)");
  }
  if (const Json* axis = fields.find("axis")) {
    edit.axis = fields.points(*axis, "axis");
    if (edit.axis->rows() != 2) fields.fail("axis", "two points [x, y, z]");
  }
  edit.options = options_of(fields);
  return edit;
}

SketchEdit glue_of(const Fields& fields) {
  GlueEdit edit;
  edit.first = stroke_in(fields, fields.require("first"), "first");
  edit.second = stroke_in(fields, fields.require("second"), "second");
  if (const Json* halves = fields.find("halves")) edit.halves = curves_of(fields, *halves, "halves");
  edit.options = options_of(fields);
  return edit;
}

SketchEdit skin_of(const Fields& fields) {
  SkinEdit edit;
  const Json &profiles = fields.require("profiles"), &spines = fields.require("spines");
  if (!profiles.is_list()) fields.fail("profiles", "a list of objects {\"points\": …}");
  for (std::size_t k = 0; k < profiles.size(); ++k)
    edit.profiles.push_back(stroke_in(fields, profiles.at(k), "profiles"));
  if (!spines.is_list() || spines.size() != 2) fields.fail("spines", "a list of two objects {\"points\": …}");
  for (std::size_t k = 0; k < 2; ++k) edit.spines[k] = stroke_in(fields, spines.at(k), "spines");
  edit.options = options_of(fields);
  return edit;
}

SketchEdit transform_of(const Fields& fields) {
  const Json& matrix = fields.require("matrix");
  const auto* numbers = matrix.get<Json::Numbers>();
  if (!numbers || numbers->size() != 16) fields.fail("matrix", "16 numbers, row by row");
  TransformEdit edit;
  for (std::size_t k = 0; k < 16; ++k)
    edit.matrix(static_cast<int>(k / 4), static_cast<int>(k % 4)) = (*numbers)[k];
  return edit;
}

struct Tool {
  std::vector<std::string> fields;
  SketchEdit (*read)(const Fields&);
};

const std::map<std::string, Tool>& tools() {
  static const std::map<std::string, Tool> kTools{
      {"insert",
       {{"points", "closed", "snap", "sharpness", "into"},
        [](const Fields& f) -> SketchEdit {
          return InsertEdit{stroke_of(f), options_of(f)};
        }}},
      {"hole",
       {{"points", "closed", "snap", "sharpness", "into"},
        [](const Fields& f) -> SketchEdit {
          return HoleEdit{stroke_of(f), options_of(f)};
        }}},
      {"delete",
       {{"curve"},
        [](const Fields& f) -> SketchEdit { return DeleteEdit{f.curve(f.require("curve"), "curve")}; }}},
      {"sharpness", {{"curve", "value", "between"}, sharpness_of}},
      {"mirror", {{"curve", "points", "closed", "axis", "snap", "sharpness", "into"}, mirror_of}},
      {"glue", {{"first", "second", "halves", "snap", "sharpness", "into"}, glue_of}},
      {"skin", {{"profiles", "spines", "snap", "sharpness", "into"}, skin_of}},
      {"align",
       {{"reference", "points", "closed"},
        [](const Fields& f) -> SketchEdit {
          return AlignEdit{f.curve(f.require("reference"), "reference"), stroke_of(f)};
        }}},
      {"transform", {{"matrix"}, transform_of}}};
  return kTools;
}

}  // namespace

void put_fields(Json& line, const SketchEdit& edit) {
  std::visit([&](const auto& e) { put_edit(line, e); }, edit);
}

std::optional<SketchEdit> sketch_edit_of(const Json& line, const std::string& op,
                                         const std::vector<std::string>& common) {
  const auto tool = tools().find(op);
  if (tool == tools().end()) return std::nullopt;
  std::vector<std::string> known = common;
  known.insert(known.end(), tool->second.fields.begin(), tool->second.fields.end());
  return tool->second.read(Fields(line, "op " + op, known));
}

}  // namespace batten::detail
