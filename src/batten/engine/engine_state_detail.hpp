#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/engine/engine.hpp"
#include "batten/engine/handle_drag_detail.hpp"
#include "batten/engine/live_surface_detail.hpp"
#include "batten/engine/message_detail.hpp"
#include "batten/engine/reply_detail.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/session/document.hpp"
#include "batten/session/results.hpp"

namespace batten {

/// What an engine keeps between messages, and what it does with each. Private to the room: engine.cpp has the
/// messages that change or show the project, engine_inspection.cpp those that ask about an object.
struct Engine::State {
  Document document;
  Results results;
  detail::LiveSurface live;
  detail::HandleDrag held;
  FormatStep format_step;

  /// The object that a message names.
  ObjectId object_of(const detail::Json& message, const char* name = "object") const;
  Content content(ObjectId id, const Progress& progress) { return results.content(document, id, progress); }
  SharedMesh mesh(ObjectId id, const Progress& progress);
  /// The curves of an object: its own, those that a surface was made of, those that were drawn, or those of
  /// the network that the message names as `curves`.
  std::shared_ptr<const CurveNetwork> curves_of(const detail::Json& message, const Progress& progress);
  /// What the drawn coordinates of an object are less.
  Eigen::RowVector3d origin_of(ObjectId id, const Progress& progress);
  /// A name that no object of the document has yet: "hull", "hull 2", …
  std::string free_name(const std::string& wanted) const;

  void apply(detail::Draft& draft, const Edit& edit);
  /// Another project in place of this one, with nothing kept of it.
  void replace(detail::Draft& draft, Document other, detail::Json warnings);

  // The messages, each with its name.
  void open(detail::Draft& draft, const detail::Json& message, std::string_view bytes,
            const Progress& progress);
  void play(detail::Draft& draft, const std::string& name, std::string_view bytes, const Progress& progress);
  void edit(detail::Draft& draft, const detail::Json& message);
  void describe(detail::Draft& draft) const;
  void show(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void follow(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  /// The surface of a scan once more, with its deviations as values.
  TriangleMesh with_uncertainty(ObjectId id, const Progress& progress);
  void values(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void continuity(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void distances(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void combs(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void directions(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void section(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void grab(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void pull(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void try_edit(detail::Draft& draft, const detail::Json& message) const;
  void save(detail::Draft& draft, const detail::Json& message, const Progress& progress);
  void colours(detail::Draft& draft) const;
  void length(detail::Draft& draft, const detail::Json& message) const;
  void carry_out(detail::Draft& draft, std::string_view text, std::string_view bytes,
                 const Progress& progress);
};

}  // namespace batten
