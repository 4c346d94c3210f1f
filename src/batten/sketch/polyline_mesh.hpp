#pragma once
#include <array>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/curves/polyline.hpp"
#include "batten/mesh/dynamic_box_tree.hpp"

namespace batten {

/// A side of an edge: 2 · edge when walked forwards, 2 · edge + 1 when walked backwards.
constexpr int side_of(int edge, bool backwards) {
  return 2 * edge + (backwards ? 1 : 0);
}
/// The same edge, walked the other way.
constexpr int opposite_side(int side) {
  return side ^ 1;
}
/// The edge that a side belongs to.
constexpr int edge_of(int side) {
  return side / 2;
}

/// A place where pieces of curves meet.
struct SketchVertex {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<int> edges;  ///< in no order
  /// Put on a closed curve only because an edge needs two ends; vanishes when the curve is met elsewhere.
  bool is_seam = false;
  bool alive = false;
  bool operator==(const SketchVertex&) const = default;
};

/// A piece of a curve between two vertices.
struct SketchEdge {
  std::array<int, 2> vertices{-1, -1};
  /// The face that walks the edge forwards and the one that walks it backwards; −1 on the border.
  std::array<int, 2> faces{-1, -1};
  SharedPolyline polyline;  ///< from the first vertex to the second
  int curve = -1;           ///< the curve that it is a piece of
  double sharpness = 0;     ///< 0 smooth … 1 sharp (H 6.4)
  bool drawn = true;        ///< false: made by a tool, its polyline is only a guess
  bool alive = false;
  /// Equal with polylines compared point by point.
  bool operator==(const SketchEdge& other) const;
};

/// A face, by the sides around it.
struct SketchFace {
  std::vector<int> sides;  ///< in order around the face, counter-clockwise seen from outside
  bool alive = false;
  bool operator==(const SketchFace&) const = default;
};

/// What the model amounts to.
struct SketchCounts {
  int curves = 0, vertices = 0, edges = 0, faces = 0, components = 0, boundary_loops = 0, genus = 0;
  int euler_characteristic() const { return vertices - edges + faces; }
  bool operator==(const SketchCounts&) const = default;
};

/// The polyline mesh M = (V, E, F, P) of H 3.3: a curve network with the faces between its curves. A face has
/// any number of sides, two or more, and need be neither flat nor convex. Several components, borders and
/// handles are possible; the surface is oriented. Curves (c0, c1, …), vertices (v0, …), edges (e0, …) and
/// faces (f0, …) keep their numbers for life; numbers are given in the order of creation and those of removed
/// elements stay empty.
///
/// Every change happens between begin() and commit() or roll_back(), else it throws InvalidInput and changes
/// nothing; so do begin(), undo() and redo() within an edit. The elements that an edit touches are
/// remembered, so that undo costs as much as the edit, not as the model.
class PolylineMesh {
 public:
  /// The touched elements of one edit, before and after.
  struct Change {
    template <typename Element>
    /// The elements of one kind that were touched, with their numbers.
    struct Part {
      std::vector<std::pair<int, Element>> before, after;
      int size_before = 0, size_after = 0;
    };
    Part<SketchVertex> vertices;
    Part<SketchEdge> edges;
    Part<SketchFace> faces;
    int n_curves_before = 0, n_curves_after = 0;
  };

  // Elements. Numbers that were removed stay in the arrays with alive == false.
  const std::vector<SketchVertex>& vertices() const { return vertices_; }
  const std::vector<SketchEdge>& edges() const { return edges_; }
  const std::vector<SketchFace>& faces() const { return faces_; }
  const SketchVertex& vertex(int v) const { return vertices_[static_cast<size_t>(v)]; }
  const SketchEdge& edge(int e) const { return edges_[static_cast<size_t>(e)]; }
  const SketchFace& face(int f) const { return faces_[static_cast<size_t>(f)]; }
  /// One more than the highest curve number given so far.
  int n_curves() const { return n_curves_; }
  bool empty() const;

  // Walking.
  int face_of(int side) const { return edge(edge_of(side)).faces[static_cast<size_t>(side & 1)]; }
  int start_of(int side) const { return edge(edge_of(side)).vertices[static_cast<size_t>(side & 1)]; }
  int end_of(int side) const { return start_of(opposite_side(side)); }
  /// Unit direction in which a side leaves its first vertex.
  Eigen::Vector3d direction_of(int side) const;
  /// The sides without a face that follow each other around the opening at `side`.
  /// @pre face_of(side) is −1.
  std::vector<int> opening(int side) const;
  /// The edges of a curve, increasing; empty when there is no such curve.
  std::vector<int> edges_of_curve(int curve) const;

  // Searching. The trees follow every change at once, also within an edit.
  /// The boxes of the polylines of all edges.
  const DynamicBoxTree& edge_boxes() const { return edge_boxes_; }
  /// For every face the box around the polylines of its sides.
  const DynamicBoxTree& face_boxes() const { return face_boxes_; }

  /// Linear in the model.
  SketchCounts counts() const;
  /// The diagonal of the box around everything: "the diameter"; 0 when empty.
  double diameter() const;

  /// The first breach of H 3.3 found, in words, or nothing: 1. an edge has two different vertices and at most
  /// two faces; 2. its polyline runs from the one to the other; 3. a vertex has at least two edges; 4. a face
  /// is a closed walk; and, because surfaces are made of it: no walk visits a vertex twice, faces agree on
  /// their orientation, every edge has a face, the faces around a vertex form one fan, references agree.
  std::string broken_invariant() const;
  /// The same for the elements that the edit under way has touched: costs as much as the edit.
  std::string broken_by_edit() const;
  /// Equal numbers, elements and coordinates, bit for bit.
  bool operator==(const PolylineMesh& other) const;

  // Changing.
  /// Begins an edit.
  void begin();
  /// Ends the edit.
  Change commit();
  /// Takes the edit under way back.
  void roll_back();
  /// Takes a change back, or makes it again. @pre the model is as it was after, or before, it.
  void undo(const Change& change);
  void redo(const Change& change);

  /// New elements; each returns its number.
  int add_curve();
  int add_vertex(const Eigen::Vector3d& position, bool is_seam = false);
  int add_edge(int from, int to, SharedPolyline polyline, int curve, double sharpness, bool drawn);
  int add_face(std::vector<int> sides);
  /// Elements taken away; their numbers are not given again.
  void remove_face(int face);
  void remove_edge(int edge);      ///< @pre no face is left at it
  void remove_vertex(int vertex);  ///< @pre no edge is left at it
  /// Cuts an edge at an arc length; the first part keeps its number. @return the new vertex.
  int split_edge(int edge, double arc_length, const Eigen::Vector3d& at);
  /// Joins the two edges of a vertex that has no others; the lower number stays.
  /// @return false, nothing done, where the result would begin and end at one vertex or another edge is here.
  bool dissolve_vertex(int vertex);
  /// Divides a face along a chain of sides that runs from corner to corner; `face` keeps the part that lies
  /// before the chain's end. @return the new face.
  int split_face(int face, const std::vector<int>& chain);
  /// Puts two faces into an opening, on either side of a chain across it.
  void close_opening(int side_of_opening, const std::vector<int>& chain);
  void set_sharpness(int edge, double sharpness);
  void set_seam(int vertex, bool is_seam);
  void move_everything(const Eigen::Matrix4d& matrix);
  /// Turns a component inside out. @param face any face of it.
  void flip_component(int face);

 private:
  void require_editing(bool wanted) const;
  std::string problem_of_edge(int number) const;
  std::string problem_of_face(int number) const;
  std::string problem_of_vertex(int number) const;
  SketchVertex& touch_vertex(int v);
  SketchEdge& touch_edge(int e);
  SketchFace& touch_face(int f);
  void replay(const Change& change, bool forwards);
  void index_edge(int e);
  void index_face(int f);
  void index_everything();
  Box box_of_face(int f) const;

  std::vector<SketchVertex> vertices_;
  std::vector<SketchEdge> edges_;
  std::vector<SketchFace> faces_;
  int n_curves_ = 0;
  bool editing_ = false;
  Change change_;
  std::vector<char> touched_vertices_, touched_edges_, touched_faces_;

  // Kept for searches; they follow from the elements.
  DynamicBoxTree edge_boxes_, face_boxes_;
  std::vector<std::vector<int>> edges_of_curve_;

  friend class PolylineMeshReader;
};

/// Puts a stored model together (see session/project.hpp).
class PolylineMeshReader {
 public:
  /// @throws InvalidInput naming the invariant that the parts break.
  static PolylineMesh assemble(std::vector<SketchVertex> vertices, std::vector<SketchEdge> edges,
                               std::vector<SketchFace> faces, int n_curves);
};

}  // namespace batten
