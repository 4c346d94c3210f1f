#include "batten/session/project.hpp"

#include <cstdint>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/zip_archive.hpp"
#include "batten/session/content_json_detail.hpp"
#include "batten/session/durable_file_detail.hpp"
#include "batten/session/edit_json.hpp"
#include "batten/session/edit_json_detail.hpp"
#include "batten/session/json_fields_detail.hpp"
#include "batten/session/project_arrays_detail.hpp"
#include "batten/session/request_json_detail.hpp"
#include "batten/session/session_text_detail.hpp"

namespace batten {

namespace {

using detail::Fields;
using detail::Json;
using Entries = std::map<std::string, std::string>;

/// The objects of a project file as they are.
struct StoredObjects {
  std::map<ObjectId, Object> objects;
  std::map<ObjectId, SharedModel> models;
};

const std::string& entry_of(const Entries& entries, const std::string& name) {
  const auto entry = entries.find(name);
  if (entry == entries.end()) throw InvalidInput(concat("the entry ", name, " is missing"));
  return entry->second;
}

Json parsed_entry(const Entries& entries, const std::string& name) {
  try {
    return detail::parse_json(entry_of(entries, name));
  } catch (const InvalidInput& error) {
    throw InvalidInput(concat(name, ": ", error.what()));
  }
}

Json json_of_object(const Document& document, ObjectId id) {
  const Object& object = document.object(id);
  Json json;
  json.add("object", detail::json_of(id));
  if (object.kind() != ObjectKind::Model || object.derived()) {
    detail::put_object(json, object);
    return json;
  }
  json.add("kind", word_of(ObjectKind::Model));
  json.add("name", object.name);
  json.add("unit", object.unit);
  json.add("content", detail::json_of_model(document.model(id)));
  return json;
}

void read_object(const Json& json, StoredObjects& stored) {
  const Fields fields(json, "an object", {"object", "kind", "name", "unit", "content", "source", "request"});
  const auto id_in = [&](const char* name) {
    return ObjectId{fields.id_of(fields.require(name), name, 'o', "the id of an object")};
  };
  const ObjectId id = id_in("object");
  Object& object = stored.objects[id];
  object.name = fields.text_of(fields.require("name"), "name");
  if (const Json* request = fields.find("request")) {
    object.body = Derived{id_in("source"), std::make_shared<const Request>(detail::request_of(*request))};
    return;
  }
  object.unit = fields.text_of(fields.require("unit"), "unit");
  const auto kind = fields.choice<ObjectKind>(fields.require("kind"), "kind");
  object.body = detail::content_of(kind, fields.require("content"));
  if (kind == ObjectKind::Model) stored.models[id] = std::get<SharedModel>(*object.content());
}

StoredObjects objects_of_format_2(const Json& project) {
  const Fields fields(project, "project.json", {"batten_project", "objects"});
  const Json& list = fields.require("objects");
  if (!list.is_list()) fields.fail("objects", "a list of objects");
  StoredObjects stored;
  for (std::size_t i = 0; i < list.size(); ++i) read_object(list.at(i), stored);
  return stored;
}

/// Format 1: one model, its coordinates in an entry of their own.
StoredObjects objects_of_format_1(const Json& project, const Entries& entries) {
  const Fields fields(project, "project.json",
                      {"batten_project", "unit", "curves", "vertices", "edges", "faces"});
  Json model;
  for (const char* name : {"curves", "vertices", "edges", "faces"}) model.add(name, fields.require(name));
  model.add("coordinates", detail::doubles_of(entry_of(entries, "coordinates.f64"), "coordinates.f64"));
  StoredObjects stored;
  const ObjectId id{1};
  stored.models[id] = std::make_shared<const PolylineMesh>(detail::model_of(model));
  stored.objects[id] = {"model", fields.text_of(fields.require("unit"), "unit"), Content(SharedModel())};
  return stored;
}

/// The document that a journal leads to, where it can be played.
std::optional<Document> replayed(const Session& session) {
  Document document;
  try {
    for (const SessionEdit& edit : session.edits) document.apply(edit.edit);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  return document;
}

}  // namespace

std::string format_project(const Document& document) {
  Entries entries;
  detail::ArrayWriter arrays(entries);
  Json::List objects;
  for (const ObjectId id : document.objects()) objects.push_back(json_of_object(document, id));
  Json project;
  project.add("batten_project", 2);
  project.add("objects", std::move(objects));
  arrays.move_out(project);
  std::string& journal = entries["journal.jsonl"] = format_session_header() + '\n';
  for (const Edit& edit : document.log()) {
    Json line = detail::json_of(edit);
    arrays.move_out(line);
    journal += detail::format_json(line) + '\n';
  }
  entries["project.json"] = detail::format_json(project, true) + '\n';
  return format_archive(entries);
}

void write_project(const std::string& path, const Document& document) {
  const std::string bytes = format_project(document);
  if (bytes.size() >= std::numeric_limits<std::uint32_t>::max())
    throw FileError(path, 0, "the project is larger than 4 GB; take large objects out of it");
  detail::write_durably(path, bytes);
}

ProjectFile parse_project(const std::string& bytes, const std::string& path) {
  ProjectFile file;
  try {
    const Entries entries = parse_archive(bytes);
    Json project = parsed_entry(entries, "project.json");
    const Json* format = project.find("batten_project");
    if (!format || (!(*format == Json(1)) && !(*format == Json(2))))
      throw InvalidInput("versions 1 and 2 of the project format are known, this is another");
    file.format = *format == Json(1) ? 1 : 2;
    detail::move_in(project, entries);
    const StoredObjects stored =
        file.format == 1 ? objects_of_format_1(project, entries) : objects_of_format_2(project);
    const Session session = detail::parse_session(entry_of(entries, "journal.jsonl"), "journal.jsonl",
                                                  [&](Json& line) { detail::move_in(line, entries); });
    file.document = Document::restored(stored.objects, stored.models);
    std::optional<Document> played = replayed(session);
    if (played && *played == file.document)
      file.document = std::move(*played);
    else
      file.warnings.push_back(
          concat(path,
                 ": its journal does not lead to the stored objects, which hold; what was done "
                 "before cannot be undone"));
  } catch (const InvalidInput& error) {
    throw FileError(path, 0, error.what());
  }
  return file;
}

ProjectFile read_project(const std::string& path) {
  return parse_project(read_file(path), path);
}

}  // namespace batten
