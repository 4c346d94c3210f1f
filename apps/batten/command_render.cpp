#include "command.hpp"
#include "model_file.hpp"

#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/standard_streams.hpp"
#include "batten/pipeline/shape_comparison.hpp"
#include "batten/render/render.hpp"

namespace batten::cli {

namespace {

struct RenderArguments {
  std::string file, output, network, against;
  std::string shading = "shaded", size = "1200x900", view = "three-quarter", projection = "perspective",
              normals = "geometry", registration = "none", up = "z";
  int stripes = 28, samples = 3;
  double zoom = 1, range = 0;
};

std::vector<Shading> parse_shadings(const std::string& text) {
  std::vector<Shading> shadings;
  for (const std::string_view name : split_fields(text, ',')) shadings.push_back(parse_choice<Shading>(name));
  return shadings;
}

void parse_size(const std::string& text, int& width, int& height) {
  const auto fields = split_fields(text, 'x');
  long w = 0, h = 0;
  if (fields.size() != 2 || !parse_integer(fields[0], w) || !parse_integer(fields[1], h) || w < 16 ||
      h < 16 || w > 16384 || h > 16384)
    throw InvalidInput(concat("a size is WIDTHxHEIGHT in pixels, 16 to 16384 each, got '", text, "'"));
  width = static_cast<int>(w);
  height = static_cast<int>(h);
}

Outcome run_render(const RenderArguments& arguments, Context& context) {
  Outcome outcome;
  Model model, network, truth;
  {
    const ScopedStage stage(outcome.times, "read");
    model = read_model(arguments.file, outcome.warnings);
    if (!arguments.network.empty()) {
      network = read_model(arguments.network, outcome.warnings);
      if (!network.network)
        throw InvalidInput(concat("--network takes a network, but ", network.path, " is a mesh"));
    }
    if (!arguments.against.empty()) truth = read_model(arguments.against, outcome.warnings);
  }
  if (model.network && network.network)
    throw InvalidInput(concat(model.path, " is a network already; --network is for a mesh"));

  const std::vector<Shading> shadings = parse_shadings(arguments.shading);
  RenderOptions options;
  parse_size(arguments.size, options.width, options.height);
  options.view = parse_view(arguments.view);
  options.view.perspective = arguments.projection == "perspective";
  options.view.zoom = arguments.zoom;
  options.view.up_axis = arguments.up[0] - 'x';
  options.samples = arguments.samples;
  options.stripes = arguments.stripes;
  options.range = arguments.range;
  options.given_normals = arguments.normals == "given";
  options.shading = shadings.front();

  Subject subject;
  subject.mesh = model.mesh ? &*model.mesh : nullptr;
  subject.network = model.network ? &*model.network : network.network ? &*network.network : nullptr;
  if (!arguments.against.empty()) {
    const ScopedStage stage(outcome.times, "compare");
    const TruthErrors errors =
        truth_errors(shape_of(model), shape_of(truth), parse_choice<RegistrationKind>(arguments.registration),
                     context.progress);
    subject.errors = errors.vertices;
    subject.error_unit = "error, % of size";
    outcome.figures["error"] = {{"max", errors.lengths.max},
                                {"mean", errors.lengths.mean},
                                {"rms", errors.lengths.rms},
                                {"diameter", errors.diameter}};
  }

  if (model.network) subject.uncertainty = read_network_uncertainty(arguments.file);

  Image image;
  {
    const ScopedStage stage(outcome.times, "draw");
    image = shadings.size() == 1 ? render(subject, options, context.progress)
                                 : contact_sheet(subject, shadings, options, context.progress);
  }
  {
    const ScopedStage stage(outcome.times, "write");
    write_file(arguments.output, encode_png(image));
  }
  outcome.figures["output"] = arguments.output;
  outcome.figures["width"] = image.width;
  outcome.figures["height"] = image.height;
  outcome.figures["vertices"] = model.positions().rows();
  if (model.mesh) outcome.figures["faces"] = model.mesh->n_triangles();
  if (subject.network != nullptr) outcome.figures["curves"] = subject.network->curves.size();
  outcome.lines.push_back(
      concat("wrote ", arguments.output, ", ", image.width, " x ", image.height, " pixels"));
  return outcome;
}

}  // namespace

void add_render(CLI::App& app) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command =
      add_command(app, "render", "Draw a mesh or a network as a PNG picture, without a screen.",
                  "batten render surface.ply -o picture.png --shading isophotes --network net.net",
                  [arguments](Context& context) { return run_render(*arguments, context); });
  std::string names;
  for (const std::string& word : choice_words<Shading>()) names += concat(names.empty() ? "" : ", ", word);
  command->add_option("FILE", arguments->file, "Mesh or network to draw")->required();
  command->add_option("-o,--output", arguments->output, "Picture to write (.png)")
      ->required()
      ->check(CLI::Validator(
          [](std::string& path) {
            return output_extension(path, "png") == "png" ? std::string()
                                                          : concat("the picture must be named *.png: ", path);
          },
          "PNG"));
  command
      ->add_option("--shading", arguments->shading, "One or several, joined by commas, for a sheet: " + names)
      ->check(parses("NAME[,NAME...]", [](const std::string& text) { parse_shadings(text); }));
  command->add_option("--size", arguments->size, "Width and height in pixels")
      ->check(parses("WIDTHxHEIGHT", [](const std::string& text) {
        int width = 0, height = 0;
        parse_size(text, width, height);
      }));
  command
      ->add_option("--view", arguments->view,
                   "three-quarter, front, back, left, right, top, bottom, or AZIMUTH,ELEVATION in degrees")
      ->check(parses("VIEW", [](const std::string& text) { parse_view(text); }));
  command->add_option("--up", arguments->up, "Axis of the file that points up: x, y, z")
      ->check(CLI::IsMember({"x", "y", "z"}));
  command->add_option("--projection", arguments->projection, "perspective or parallel")
      ->check(CLI::IsMember({"perspective", "parallel"}));
  command->add_option("--zoom", arguments->zoom, "Enlarge about the middle of the picture")
      ->check(CLI::Range(0.01, 1000.0));
  command->add_option("--network", arguments->network, "Draw this network upon the mesh");
  command->add_option("--against", arguments->against, "Truth for the shading error: a mesh or a network");
  command
      ->add_option("--register", arguments->registration,
                   "Move FILE onto the truth first: none, rigid, similarity")
      ->check(CLI::IsMember({"none", "rigid", "similarity"}));
  command->add_option("--normals", arguments->normals, "geometry: of the triangles; given: those in the file")
      ->check(CLI::IsMember({"geometry", "given"}));
  command->add_option("--stripes", arguments->stripes, "Isophotes or reflection lines over half a turn")
      ->check(CLI::Range(1, 1000));
  command->add_option("--range", arguments->range, "End of the colour bar; 0 cuts the extreme percent")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--samples", arguments->samples, "Samples per pixel in each direction")
      ->check(CLI::Range(1, 8));
}

}  // namespace batten::cli
