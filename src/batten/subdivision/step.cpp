// STEP and IGES through Open Cascade; the only source that includes it. Topology is built directly from that
// of the patches, so that nothing depends on a sewing tolerance.
#include "batten/subdivision/step.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <sstream>

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Eigen/Geometry>
#include <GProp_GProps.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom2d_Line.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESData_IGESWriter.hxx>
#include <IGESData_Protocol.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <StepBasic_Product.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TransferBRep.hxx>
#include <TransferBRep_ShapeMapper.hxx>
#include <Transfer_FinderProcess.hxx>
#include <XSControl_TransferWriter.hxx>
#include <XSControl_WorkSession.hxx>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

#if defined(BATTEN_SANITIZED)
/// Open Cascade never frees some tables of its readers and writers; the leak check of our own code stays.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libTK\n";
}
#endif

namespace batten {

namespace {

/// Open Cascade keeps parameters and messages in globals; one file at a time.
std::mutex& open_cascade() {
  static std::mutex mutex;
  return mutex;
}

/// What Open Cascade allows between things that are the same, in mm; ours differ by rounding only.
constexpr double kTolerance = 1e-7;

/// Knots with their multiplicities, as Open Cascade wants them.
struct Knots {
  explicit Knots(const std::vector<double>& knots) {
    for (const double knot : knots) {
      if (values.empty() || knot != values.back()) {
        values.push_back(knot);
        multiplicities.push_back(0);
      }
      ++multiplicities.back();
    }
  }
  TColStd_Array1OfReal values_array() const {
    TColStd_Array1OfReal array(1, static_cast<int>(values.size()));
    for (size_t k = 0; k < values.size(); ++k) array.SetValue(static_cast<int>(k) + 1, values[k]);
    return array;
  }
  TColStd_Array1OfInteger multiplicities_array() const {
    TColStd_Array1OfInteger array(1, static_cast<int>(multiplicities.size()));
    for (size_t k = 0; k < multiplicities.size(); ++k)
      array.SetValue(static_cast<int>(k) + 1, multiplicities[k]);
    return array;
  }
  std::vector<double> values;
  std::vector<int> multiplicities;
};

gp_Pnt to_point(const Points& points, Eigen::Index row, double scale) {
  return {scale * points(row, 0), scale * points(row, 1), scale * points(row, 2)};
}

Handle(Geom_BSplineCurve) to_curve(const BsplineCurve& curve, double scale) {
  const Knots knots(curve.knots);
  TColgp_Array1OfPnt poles(1, static_cast<int>(curve.control_points.rows()));
  for (Eigen::Index i = 0; i < curve.control_points.rows(); ++i)
    poles.SetValue(static_cast<int>(i) + 1, to_point(curve.control_points, i, scale));
  return new Geom_BSplineCurve(poles, knots.values_array(), knots.multiplicities_array(), 3);
}

Handle(Geom_BSplineSurface) to_surface(const BsplinePatch& patch, double scale) {
  const Knots u(patch.knots_u), v(patch.knots_v);
  TColgp_Array2OfPnt poles(1, static_cast<int>(patch.n_u()), 1, static_cast<int>(patch.n_v()));
  for (Eigen::Index j = 0; j < patch.n_v(); ++j)
    for (Eigen::Index i = 0; i < patch.n_u(); ++i)
      poles.SetValue(static_cast<int>(i) + 1, static_cast<int>(j) + 1,
                     to_point(patch.control_points, j * patch.n_u() + i, scale));
  return new Geom_BSplineSurface(poles, u.values_array(), v.values_array(), u.multiplicities_array(),
                                 v.multiplicities_array(), 3, 3);
}

/// Side k of the unit square as a line of its parameter along the edge, 0 to 1.
Handle(Geom2d_Line) side_line(int side, bool forward) {
  static const double kCorners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const double* from = kCorners[forward ? side : (side + 1) % 4];
  const double* to = kCorners[forward ? (side + 1) % 4 : side];
  return new Geom2d_Line(gp_Pnt2d(from[0], from[1]), gp_Dir2d(to[0] - from[0], to[1] - from[1]));
}

/// Per patch the first patch of its connected part.
std::vector<int> components(const BsplineSurface& surface) {
  DisjointSets parts(static_cast<int>(surface.patches.size()));
  for (const BsplineEdge& edge : surface.edges)
    if (edge.patches[1] >= 0) parts.unite(edge.patches[0], edge.patches[1]);
  std::vector<int> first(surface.patches.size());
  for (int f = 0; f < parts.size(); ++f) first[static_cast<size_t>(f)] = parts.root(f);
  return first;
}

/// A surface as Open Cascade has it.
struct CadShape {
  TopoDS_Shape shape;
  std::vector<TopoDS_Face> faces;  ///< of the patches
  std::vector<TopoDS_Edge> edges;
};

CadShape to_shape(const BsplineSurface& surface, double scale) {
  const BRep_Builder builder;
  CadShape made;
  made.faces.resize(surface.patches.size());
  std::vector<TopoDS_Vertex> vertices(static_cast<size_t>(surface.vertices.rows()));
  for (size_t v = 0; v < vertices.size(); ++v)
    builder.MakeVertex(vertices[v], to_point(surface.vertices, static_cast<Eigen::Index>(v), scale),
                       kTolerance);
  std::vector<TopoDS_Edge>& edges = made.edges;
  edges.resize(surface.edges.size());
  for (size_t e = 0; e < edges.size(); ++e) {
    const BsplineEdge& edge = surface.edges[e];
    builder.MakeEdge(edges[e], to_curve(edge.curve, scale), kTolerance);
    TopoDS_Vertex first = vertices[static_cast<size_t>(edge.vertices[0])];
    TopoDS_Vertex last = vertices[static_cast<size_t>(edge.vertices[1])];
    builder.Add(edges[e], first.Oriented(TopAbs_FORWARD));
    builder.Add(edges[e], last.Oriented(TopAbs_REVERSED));
    builder.Range(edges[e], 0, 1);
  }
  const std::vector<int> component = components(surface);
  TopoDS_Compound compound;
  builder.MakeCompound(compound);
  int n_shapes = 0;
  TopoDS_Shape last_shape;
  for (size_t c = 0; c < component.size(); ++c) {
    if (component[c] != static_cast<int>(c)) continue;
    TopoDS_Shell shell;
    builder.MakeShell(shell);
    bool closed = true;
    for (size_t f = c; f < component.size(); ++f) {
      if (component[f] != static_cast<int>(c)) continue;
      const BsplinePatch& patch = surface.patches[f];
      TopoDS_Face& face = made.faces[f];
      builder.MakeFace(face, to_surface(patch, scale), kTolerance);
      TopoDS_Wire wire;
      builder.MakeWire(wire);
      for (int k = 0; k < 4; ++k) {
        const size_t e = static_cast<size_t>(patch.edges[static_cast<size_t>(k)]);
        const bool forward = surface.edges[e].vertices[0] == patch.vertices[static_cast<size_t>(k)];
        builder.UpdateEdge(edges[e], side_line(k, forward), face, kTolerance);
        builder.Range(edges[e], face, 0, 1);
        builder.SameRange(edges[e], true);
        builder.SameParameter(edges[e], true);
        builder.Add(wire, edges[e].Oriented(forward ? TopAbs_FORWARD : TopAbs_REVERSED));
        closed = closed && surface.edges[e].patches[1] >= 0;
      }
      wire.Closed(true);
      builder.Add(face, wire);
      builder.Add(shell, face);
    }
    shell.Closed(closed);
    last_shape = shell;
    if (closed) {
      TopoDS_Solid solid;
      builder.MakeSolid(solid);
      builder.Add(solid, shell);
      BRepLib::OrientClosedSolid(solid);
      last_shape = solid;
    }
    builder.Add(compound, last_shape);
    ++n_shapes;
  }
  made.shape = n_shapes == 1 ? last_shape : compound;
  return made;
}

void silence() {
  Message::DefaultMessenger()->ChangePrinters().Clear();
}

Handle(TCollection_HAsciiString) ascii(const std::string& text) {
  std::string plain;
  for (const char c : text) plain += c >= 32 && c < 127 && c != '\'' ? c : '_';
  return new TCollection_HAsciiString(plain.c_str());
}

/// The widest gap between the curve of an edge, the surface under it and its vertices.
double largest_gap(const TopoDS_Shape& shape) {
  double gap = 0;
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next()) {
    const TopoDS_Face face = TopoDS::Face(faces.Current());
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
    for (TopExp_Explorer sides(face, TopAbs_EDGE); sides.More(); sides.Next()) {
      const TopoDS_Edge edge = TopoDS::Edge(sides.Current());
      double first = 0, last = 0, first_2d = 0, last_2d = 0;
      const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
      const Handle(Geom2d_Curve) trace = BRep_Tool::CurveOnSurface(edge, face, first_2d, last_2d);
      if (curve.IsNull() || trace.IsNull()) return HUGE_VAL;
      constexpr int kSamples = 16;
      for (int k = 0; k <= kSamples; ++k) {
        const double t = static_cast<double>(k) / kSamples;
        const gp_Pnt2d uv = trace->Value((1 - t) * first_2d + t * last_2d);
        gap =
            std::max(gap, curve->Value((1 - t) * first + t * last).Distance(surface->Value(uv.X(), uv.Y())));
      }
      const TopoDS_Vertex from = TopExp::FirstVertex(edge), to = TopExp::LastVertex(edge);
      gap = std::max({gap, BRep_Tool::Pnt(from).Distance(curve->Value(first)),
                      BRep_Tool::Pnt(to).Distance(curve->Value(last))});
    }
  }
  return gap;
}

int count(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
  TopTools_IndexedMapOfShape map;
  TopExp::MapShapes(shape, kind, map);
  return map.Extent();
}

bool every_edge_has_two_faces(const TopoDS_Shape& shape) {
  TopTools_IndexedDataMapOfShapeListOfShape faces_of_edge;
  TopExp::MapShapesAndAncestors(shape, TopAbs_EDGE, TopAbs_FACE, faces_of_edge);
  for (int e = 1; e <= faces_of_edge.Extent(); ++e)
    if (faces_of_edge(e).Extent() != 2) return false;
  return faces_of_edge.Extent() > 0;
}

std::vector<double> flat_knots(const TColStd_Array1OfReal& knots) {
  std::vector<double> flat;
  for (int k = knots.Lower(); k <= knots.Upper(); ++k) flat.push_back(knots(k));
  return flat;
}

/// @throws InvalidInput naming what cannot be written.
void check(const BsplineSurface& surface, const StepOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (surface.patches.empty()) throw InvalidInput("the surface has no patches to write");
  for (const BsplineEdge& edge : surface.edges) {
    double length = 0;
    for (Eigen::Index i = 1; i < edge.curve.control_points.rows(); ++i)
      length += (edge.curve.control_points.row(i) - edge.curve.control_points.row(i - 1)).norm();
    length *= options.millimetres_per_unit;
    if (!(length > 100 * kTolerance))
      throw InvalidInput(
          concat("the edge between vertices ", edge.vertices[0], " and ", edge.vertices[1], " is ", length,
                 " mm long, too short for CAD; check the unit of the cage, or join these vertices"));
  }
}

/// Eight decimals of millimetres, a tenth of the tolerance, for all that is smaller than a kilometre; else 16
/// digits instead of Open Cascade's 13. Its buffer holds 24 characters, and where it cuts zeros it cuts off
/// those of exponents too.
void set_digits(Interface_FloatWriter& writer, const BsplineSurface& surface, const StepOptions& options) {
  double largest = 0;
  for (const BsplinePatch& patch : surface.patches)
    largest = std::max(largest, options.millimetres_per_unit * patch.control_points.cwiseAbs().maxCoeff());
  const bool fixed = largest < 1e6;
  writer.SetFormat(fixed ? "%.8f" : "%.15E");
  writer.SetZeroSuppress(fixed);
}

/// Gives faces and edges the names of the options, in the entities that Open Cascade has made of them.
void name_items(const Handle(Transfer_FinderProcess) & process, const BsplineSurface& surface,
                const CadShape& made, const StepOptions& options) {
  const auto set_name = [&](const TopoDS_Shape& shape, const std::vector<std::string>& names, std::size_t k) {
    if (k >= names.size() || names[k].empty()) return;
    Handle(StepRepr_RepresentationItem) item;
    if (process->FindTypedTransient(TransferBRep::ShapeMapper(process, shape),
                                    STANDARD_TYPE(StepRepr_RepresentationItem), item))
      item->SetName(ascii(names[k]));
  };
  for (std::size_t f = 0; f < made.faces.size(); ++f)
    set_name(made.faces[f], options.face_names, static_cast<std::size_t>(surface.patches[f].face));
  for (std::size_t e = 0; e < made.edges.size(); ++e) set_name(made.edges[e], options.edge_names, e);
}

/// @throws InvalidInput where there is no shape.
StepModel described(const TopoDS_Shape& shape) {
  if (shape.IsNull()) throw InvalidInput("the file holds no shape");
  StepModel model;
  model.n_solids = count(shape, TopAbs_SOLID);
  model.n_shells = count(shape, TopAbs_SHELL);
  model.n_faces = count(shape, TopAbs_FACE);
  model.n_edges = count(shape, TopAbs_EDGE);
  model.n_vertices = count(shape, TopAbs_VERTEX);
  model.is_valid = BRepCheck_Analyzer(shape).IsValid();
  model.is_closed = every_edge_has_two_faces(shape);
  // Adaptive integration per face; the plain one takes a fixed number of points and is off by 1e-4.
  GProp_GProps area, volume;
  BRepGProp::SurfaceProperties(shape, area, 1e-6);
  model.area = area.Mass();
  if (model.n_solids > 0) {
    BRepGProp::VolumeProperties(shape, volume, 1e-6, true);
    model.volume = volume.Mass();
  }
  model.largest_gap = largest_gap(shape);
  Eigen::AlignedBox3d box;
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next()) {
    const Handle(Geom_BSplineSurface) surface =
        Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(TopoDS::Face(faces.Current())));
    if (surface.IsNull() || surface->UDegree() != 3 || surface->VDegree() != 3 || surface->IsURational() ||
        surface->IsVRational())
      continue;
    BsplinePatch patch;
    patch.knots_u = flat_knots(surface->UKnotSequence());
    patch.knots_v = flat_knots(surface->VKnotSequence());
    patch.control_points.resize(patch.n_u() * patch.n_v(), 3);
    for (int j = 0; j < surface->NbVPoles(); ++j)
      for (int i = 0; i < surface->NbUPoles(); ++i) {
        const gp_Pnt pole = surface->Pole(i + 1, j + 1);
        const Eigen::Vector3d point(pole.X(), pole.Y(), pole.Z());
        patch.control_points.row(j * patch.n_u() + i) = point.transpose();
        box.extend(point);
      }
    model.patches.push_back(std::move(patch));
  }
  if (!box.isEmpty()) model.diameter = box.diagonal().norm();
  return model;
}

}  // namespace

bool has_step() {
  return true;
}

void require_step() {}

std::string format_step(const BsplineSurface& surface, const StepOptions& options) {
  check(surface, options);
  const std::lock_guard<std::mutex> lock(open_cascade());
  try {
    silence();
    STEPControl_Writer writer;
    Interface_Static::SetCVal("write.step.unit", "MM");
    Interface_Static::SetIVal("write.surfacecurve.mode", 1);
    const CadShape made = to_shape(surface, options.millimetres_per_unit);
    if (writer.Transfer(made.shape, STEPControl_AsIs) != IFSelect_RetDone)
      throw Error("Open Cascade could not turn the surface into STEP entities");
    const Handle(StepData_StepModel) model = writer.Model();
    // Open Cascade numbers its products through the life of the process.
    for (int k = 1; k <= model->NbEntities(); ++k) {
      const Handle(StepBasic_Product) product = Handle(StepBasic_Product)::DownCast(model->Entity(k));
      if (product.IsNull()) continue;
      product->SetId(ascii(options.name));
      product->SetName(ascii(options.name));
    }
    name_items(writer.WS()->TransferWriter()->FinderProcess(), surface, made, options);
    APIHeaderSection_MakeHeader header(model);
    header.SetName(ascii(options.name));
    header.SetTimeStamp(ascii("1970-01-01T00:00:00"));  // the same surface, the same file
    header.SetPreprocessorVersion(ascii("Open Cascade"));
    header.SetOriginatingSystem(ascii("Batten"));
    header.Apply(model);
    StepData_StepWriter step(model);
    set_digits(step.FloatWriter(), surface, options);
    step.SendModel(Handle(StepData_Protocol)::DownCast(model->Protocol()));
    std::ostringstream text;
    if (!step.Print(text)) throw Error("Open Cascade could not write the STEP entities");
    return text.str();
  } catch (const Standard_Failure& failure) {
    throw Error(concat("Open Cascade failed to write STEP: ", failure.GetMessageString()));
  }
}

std::string format_iges(const BsplineSurface& surface, const StepOptions& options) {
  check(surface, options);
  const std::lock_guard<std::mutex> lock(open_cascade());
  try {
    silence();
    IGESControl_Controller::Init();
    constexpr int kSolids = 1;  // boundary representations instead of loose trimmed surfaces
    IGESControl_Writer writer("MM", kSolids);
    if (!writer.AddShape(to_shape(surface, options.millimetres_per_unit).shape))
      throw Error("Open Cascade could not turn the surface into IGES entities");
    writer.ComputeModel();
    const Handle(IGESData_IGESModel) model = writer.Model();
    IGESData_GlobalSection header = model->GlobalSection();
    const Handle(TCollection_HAsciiString) date =
        ascii("19700101.000000");  // the same surface, the same file
    header.SetDate(date);
    header.SetLastChangeDate(date);
    header.SetSendName(ascii(options.name));
    header.SetReceiveName(ascii(options.name));
    header.SetFileName(ascii(options.name));
    header.SetSystemId(ascii("Batten"));
    header.SetAuthorName(ascii("Batten"));
    model->SetGlobalSection(header);
    IGESData_IGESWriter iges(model);
    set_digits(iges.FloatWriter(), surface, options);
    iges.SendModel(Handle(IGESData_Protocol)::DownCast(model->Protocol()));
    std::ostringstream text;
    if (!iges.Print(text)) throw Error("Open Cascade could not write the IGES entities");
    return text.str();
  } catch (const Standard_Failure& failure) {
    throw Error(concat("Open Cascade failed to write IGES: ", failure.GetMessageString()));
  }
}

StepModel read_step(const std::string& text) {
  const std::lock_guard<std::mutex> lock(open_cascade());
  try {
    silence();
    STEPControl_Reader reader;
    Interface_Static::SetCVal("xstep.cascade.unit", "MM");
    std::istringstream in(text);
    if (text.compare(0, 13, "ISO-10303-21;") != 0 || reader.ReadStream("model", in) != IFSelect_RetDone)
      throw InvalidInput("this is no STEP file; expected it to begin with ISO-10303-21;");
    reader.TransferRoots();
    return described(reader.OneShape());
  } catch (const Standard_Failure& failure) {
    throw InvalidInput(concat("Open Cascade failed to read the STEP file: ", failure.GetMessageString()));
  }
}

StepModel read_iges(const std::string& path) {
  const std::lock_guard<std::mutex> lock(open_cascade());
  try {
    silence();
    IGESControl_Controller::Init();
    IGESControl_Reader reader;
    Interface_Static::SetCVal("xstep.cascade.unit", "MM");
    if (reader.ReadFile(path.c_str()) != IFSelect_RetDone)
      throw InvalidInput(concat(path, " is no IGES file"));
    reader.TransferRoots();
    return described(reader.OneShape());
  } catch (const Standard_Failure& failure) {
    throw InvalidInput(concat("Open Cascade failed to read ", path, ": ", failure.GetMessageString()));
  }
}

}  // namespace batten
