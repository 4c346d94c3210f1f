#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/session/document.hpp"

// Private to the room: what an edit will do to the objects of a document, before anything is done.
namespace batten::detail {

struct PlannedObject {
  ObjectId id;
  std::shared_ptr<const Object> object;  ///< null: removed
  bool new_version = true;               ///< results that depend on it are out of date
};

struct Plan {
  ObjectId object;                     ///< the one that is edited or added
  std::vector<PlannedObject> objects;  ///< of which it is one, ascending
  std::optional<PolylineMesh> model;   ///< of an added one
  int next = 0;                        ///< number of the next object, where this edit changes it
  std::vector<std::string> options;    ///< of a request that change
};

class DocumentPlanner {
 public:
  explicit DocumentPlanner(const Document& document) : document_(document) {}

  /// Fills in the number of an object that is added, and lets a request share lists with the one before it.
  /// @throws RefusedEdit with reason and remedy.
  Plan plan(Edit& edit) const;

 private:
  Plan plan_of(AddEdit& edit) const;
  Plan plan_of(DeriveEdit& edit) const;
  Plan plan_of(const RemoveEdit& edit) const;
  Plan plan_of(const RenameEdit& edit) const;
  Plan plan_of(const UnitEdit& edit) const;
  Plan plan_of(const ReplaceEdit& edit) const;
  Plan plan_of(const ScanCurveEdit& edit) const;
  Plan plan_of(RequestEdit& edit) const;
  Plan plan_of(const ViewEdit& edit) const;
  Plan plan_of(const ModelEdit& edit) const;

  const Object& require(ObjectId id) const;
  ObjectId number_for(ObjectId wanted) const;
  void check_name(const std::string& name) const;
  void check_request(const Object& source, const Request& request) const;
  Plan added(ObjectId id, Object object) const;
  /// `object` takes the place of the one that there is, and what is made of it is out of date.
  Plan changed(ObjectId id, std::shared_ptr<const Object> object) const;
  Plan changed(ObjectId id, Object object) const;

  const Document& document_;
};

}  // namespace batten::detail
