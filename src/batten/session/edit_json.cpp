#include "batten/session/edit_json.hpp"

#include <array>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/session/content_json_detail.hpp"
#include "batten/session/edit_json_detail.hpp"
#include "batten/session/json_fields_detail.hpp"
#include "batten/session/request_json_detail.hpp"
#include "batten/session/sketch_edit_json_detail.hpp"

namespace batten {

namespace detail {

namespace {

constexpr const char* kTools = "insert, delete, sharpness, mirror, hole, glue, skin, align, transform, ";

ObjectId id_in(const Fields& fields, const char* name) {
  return {fields.id_of(fields.require(name), name, 'o', "the id of an object, such as \"o3\"")};
}

std::string text_in(const Fields& fields, const char* name) {
  return fields.text_of(fields.require(name), name);
}

void put(Json& line, const AddEdit& edit) {
  put_object(line, {edit.name, edit.unit, edit.content});
}
void put(Json& line, const DeriveEdit& edit) {
  line.add("name", edit.name);
  line.add("source", json_of(edit.source));
  line.add("request", json_of(edit.request));
}
void put(Json& line, const RemoveEdit& edit) {
  if (edit.with_derived) line.add("with_derived", true);
}
void put(Json& line, const RenameEdit& edit) {
  line.add("name", edit.name);
}
void put(Json& line, const UnitEdit& edit) {
  line.add("unit", edit.unit);
}
void put(Json& line, const ReplaceEdit& edit) {
  line.add("kind", word_of(kind_of(edit.content)));
  line.add("content", json_of(edit.content));
}
void put(Json& line, const ScanCurveEdit& edit) {
  line.add("curve", static_cast<double>(edit.curve));
  line.add("content", json_of(*edit.content));
}
void put(Json& line, const RequestEdit& edit) {
  line.add("request", json_of(edit.request));
}
void put(Json& line, const ViewEdit& edit) {
  line.add("content", json_of(Content(edit.view)));
}
void put(Json& line, const ModelEdit& edit) {
  put_fields(line, edit.edit);
}

Edit read_add(const Json& line) {
  const Fields fields(line, "op add", {"op", "object", "kind", "name", "unit", "content"});
  const auto kind = fields.choice<ObjectKind>(fields.require("kind"), "kind");
  return AddEdit{id_in(fields, "object"), text_in(fields, "name"), text_in(fields, "unit"),
                 content_of(kind, fields.require("content"))};
}
Edit read_derive(const Json& line) {
  const Fields fields(line, "op derive", {"op", "object", "name", "source", "request"});
  return DeriveEdit{id_in(fields, "object"), text_in(fields, "name"), id_in(fields, "source"),
                    request_of(fields.require("request"))};
}
Edit read_remove(const Json& line) {
  const Fields fields(line, "op remove", {"op", "object", "with_derived"});
  return RemoveEdit{id_in(fields, "object"), fields.flag("with_derived")};
}
Edit read_rename(const Json& line) {
  const Fields fields(line, "op rename", {"op", "object", "name"});
  return RenameEdit{id_in(fields, "object"), text_in(fields, "name")};
}
Edit read_unit(const Json& line) {
  const Fields fields(line, "op unit", {"op", "object", "unit"});
  return UnitEdit{id_in(fields, "object"), text_in(fields, "unit")};
}
Edit read_replace(const Json& line) {
  const Fields fields(line, "op replace", {"op", "object", "kind", "content"});
  const auto kind = fields.choice<ObjectKind>(fields.require("kind"), "kind");
  return ReplaceEdit{id_in(fields, "object"), content_of(kind, fields.require("content"))};
}
Edit read_curve(const Json& line) {
  const Fields fields(line, "op curve", {"op", "object", "curve", "content"});
  return ScanCurveEdit{
      id_in(fields, "object"), fields.integer_of(fields.require("curve"), "curve"),
      std::make_shared<const ScanCurve>(scan_curve_of(fields.require("content"), "the curve")), 0};
}
Edit read_request(const Json& line) {
  const Fields fields(line, "op request", {"op", "object", "request"});
  return RequestEdit{id_in(fields, "object"), request_of(fields.require("request")), 0};
}
Edit read_view(const Json& line) {
  const Fields fields(line, "op view", {"op", "object", "content"});
  return ViewEdit{id_in(fields, "object"),
                  std::get<ViewState>(content_of(ObjectKind::View, fields.require("content"))), 0};
}
template <typename E>
Edit read_plain(const Json& line) {
  const Fields fields(line, "op " + *line.find("op")->get<std::string>(), {"op"});
  return E{};
}

struct Op {
  const char* name;
  Edit (*read)(const Json&);
};
constexpr std::array<Op, 12> kOps{{{"add", read_add},
                                   {"derive", read_derive},
                                   {"remove", read_remove},
                                   {"rename", read_rename},
                                   {"unit", read_unit},
                                   {"replace", read_replace},
                                   {"curve", read_curve},
                                   {"request", read_request},
                                   {"view", read_view},
                                   {"undo", read_plain<UndoEdit>},
                                   {"redo", read_plain<RedoEdit>},
                                   {"checkpoint", read_plain<CheckpointEdit>}}};

std::string op_of(const Json& line) {
  const Json* op = line.find("op");
  const auto* text = op ? op->get<std::string>() : nullptr;
  return text ? *text : std::string();
}

[[noreturn]] void refuse_op(const std::string& op, const std::string& ops) {
  throw InvalidInput(
      concat(op.empty() ? std::string("the line has no \"op\"") : concat("there is no op \"", op, "\""),
             "; the ops are ", ops));
}

Json parsed_line(std::string_view text) {
  Json line;
  try {
    line = parse_json(text);
  } catch (const InvalidInput&) {
    throw InvalidInput(
        "the line is not JSON; expected one object such as {\"op\":\"undo\"} "
        "(numbers must be finite, without NaN)");
  }
  if (!line.get<Json::Object>())
    throw InvalidInput("the line is not a JSON object; expected one such as {\"op\":\"undo\"}");
  return line;
}

}  // namespace

Json json_of(ObjectId id) {
  return id_text('o', id.number);
}

void put_object(Json& line, const Object& object) {
  if (const Derived* derived = object.derived()) {
    line.add("name", object.name);
    line.add("source", json_of(derived->source));
    line.add("request", json_of(*derived->request));
    return;
  }
  line.add("kind", word_of(object.kind()));
  line.add("name", object.name);
  line.add("unit", object.unit);
  line.add("content", json_of(*object.content()));
}

Json json_of(const Edit& edit) {
  Json line;
  line.add("op", name_of_op(edit));
  std::visit(
      [&](const auto& e) {
        if constexpr (requires { e.object; }) {
          line.add("object", json_of(e.object));
          put(line, e);
        }
      },
      edit);
  return line;
}

Edit edit_of(const Json& line) {
  const std::string op = op_of(line);
  if (const auto tool = sketch_edit_of(line, op, {"op", "object"}))
    return ModelEdit{id_in(Fields(line, "op " + op), "object"), *tool, 0};
  std::string names;
  for (const Op& known : kOps) {
    if (op == known.name) return known.read(line);
    names += (names.empty() ? "" : ", ") + std::string(known.name);
  }
  refuse_op(op, kTools + names);
}

Edit edit_of_format_1(const Json& line) {
  const std::string op = op_of(line);
  if (const auto tool = sketch_edit_of(line, op, {"op"})) return ModelEdit{ObjectId{1}, *tool, 0};
  if (op == "undo") return read_plain<UndoEdit>(line);
  if (op == "redo") return read_plain<RedoEdit>(line);
  refuse_op(op, kTools + std::string("undo, redo"));
}

}  // namespace detail

std::string format_edit(const Edit& edit) {
  return detail::format_json(detail::json_of(edit));
}

Edit parse_edit(std::string_view text) {
  return detail::edit_of(detail::parsed_line(text));
}

Edit parse_edit_of_format_1(std::string_view text) {
  return detail::edit_of_format_1(detail::parsed_line(text));
}

bool is_whole_json(std::string_view text) {
  return detail::is_json(text);
}

std::string format_session_header() {
  return R"({"batten_session":2})";
}

SessionHeader parse_session_header(std::string_view text) {
  using detail::Json;
  const std::string expected = R"(the first line of a journal is {"batten_session":2})";
  Json line;
  try {
    line = detail::parse_json(text);
  } catch (const InvalidInput&) {
    throw InvalidInput(expected);
  }
  const Json* format = line.find("batten_session");
  if (!format) throw InvalidInput(expected);
  if (*format == Json(2)) {
    detail::Fields(line, "the header", {"batten_session"});
    return {2, ""};
  }
  if (!(*format == Json(1)))
    throw InvalidInput(concat("this is version ", detail::shown(*format),
                              " of the session format; versions 1 and 2 are known"));
  const detail::Fields fields(line, "the header", {"batten_session", "unit"});
  const Json* unit = fields.find("unit");
  if (unit && !unit->get<std::string>()) fields.fail("unit", "a text such as \"m\" or \"mm\"");
  return {1, unit ? *unit->get<std::string>() : "m"};
}

}  // namespace batten
