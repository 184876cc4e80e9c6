#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_msgs/String.h>

#include "base/read_file.h"
#include "ros_bridge/bag_session.h"
#include "ros_bridge/bag_writer.h"

namespace mm {
namespace {

/// rosbag notes who published; BagWriter, which writes what mm imports and simulates, signs with its own
/// name.
bool publishedByANode(const rosbag::ConnectionInfo& connection) {
  if (!connection.header) return false;
  const auto by = connection.header->find("callerid");
  return by != connection.header->end() && by->second != kBagWriterName;
}

/// @return empty: its index cannot be read.
std::string originOf(const std::filesystem::path& file) {
  try {
    rosbag::Bag bag(file.string(), rosbag::bagmode::Read);
    rosbag::View all(bag);
    for (const rosbag::ConnectionInfo* connection : all.getConnections())
      if (publishedByANode(*connection)) return "recorded on a machine";
    rosbag::View imported(bag, rosbag::TopicQuery("/imported_from"));
    for (const rosbag::MessageInstance& message : imported)
      if (const auto name = message.instantiate<std_msgs::String>()) return "imported from " + name->data;
    return "simulated";
  } catch (const std::exception&) {
    return {};
  }
}

/// @throw UnreadableFile: the disk does not give all of it.
void readThrough(const std::filesystem::path& file) {
  constexpr std::size_t kBlock = 1 << 20;
  for (std::size_t at = 0, got = kBlock; got == kBlock; at += got)
    got = readPartOfFile(file, at, kBlock, "name another file").size();
}

}  // namespace

std::string bagOrigin(const std::filesystem::path& file) {
  std::string origin = originOf(file);
  if (!origin.empty()) return origin;
  readThrough(file);  // what the disk does not give is not damaged
  origin = originOf(file);
  return origin.empty() ? "damaged" : origin;
}

}  // namespace mm
