#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/file.hpp"
#include "batten/network/curve_network.hpp"

// What the readers of the network formats share. Private to the room.
namespace batten::detail {

/// A reader's result: the network and its warnings.
struct RawNetwork {
  CurveNetwork network;
  std::vector<std::string> warnings;
};

RawNetwork parse_net(std::string content, const std::string& path);
RawNetwork parse_obj_network(std::string content, const std::string& path);
RawNetwork parse_curve_text(std::string content, const std::string& path);
RawNetwork parse_bsplines(std::string content, const std::string& path);
/// Both JSON forms: the network of docs/files.md and curves on a mesh.
RawNetwork parse_json_network(const std::string& content, const std::string& path);

std::string net_text(const CurveNetwork& network);
std::string obj_network_text(const CurveNetwork& network);
/// @param uncertainty per vertex, or empty.
std::string json_network_text(const CurveNetwork& network, const Eigen::VectorXd& uncertainty = {});
/// What json_network_text() wrote of it; empty where there is none.
Eigen::VectorXd parse_json_uncertainty(const std::string& content, const std::string& path);

}  // namespace batten::detail
