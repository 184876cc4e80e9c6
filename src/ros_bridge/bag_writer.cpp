#include "ros_bridge/bag_writer.h"

#include <fcntl.h>
#include <rosbag/constants.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/error.h"

namespace mm {
namespace {

/// Little-endian bytes of a number, as all of ROS.
template <typename T>
std::string bytes(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string field(const std::string& name, const std::string& value) {
  const std::string text = name + static_cast<char>(rosbag::FIELD_DELIM) + value;
  return bytes(static_cast<std::uint32_t>(text.size())) + text;
}

std::string op(unsigned char code) { return field(rosbag::OP_FIELD_NAME, bytes(code)); }

std::string withLength(const std::string& part) {
  return bytes(static_cast<std::uint32_t>(part.size())) + part;
}

/// Seconds in the low, nanoseconds in the high half: the eight bytes of a stamp in a bag.
std::uint64_t packed(const ros::Time& time) { return static_cast<std::uint64_t>(time.nsec) << 32 | time.sec; }

}  // namespace

BagWriter::BagWriter(const std::filesystem::path& file, std::string shownAs) : shownAs_(std::move(shownAs)) {
  file_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file_ < 0) fail("made");
  writeBytes("#ROSBAG V" + rosbag::VERSION + "\n");
  writeFileHeader();
  chunk_.reserve(kChunk + 65536);
}

BagWriter::~BagWriter() {
  if (file_ >= 0) ::close(file_);
}

void BagWriter::fail(const std::string& doing) const {
  throw InputError(shownAs_ + ": cannot be " + doing + ": " + std::strerror(errno));
}

void BagWriter::writeBytes(const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(file_, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("written");
    at += written;
    size -= static_cast<std::size_t>(written);
    position_ += static_cast<std::uint64_t>(written);
  }
}

void BagWriter::writeFileHeader() {
  const std::string header =
      op(rosbag::OP_FILE_HEADER) + field(rosbag::INDEX_POS_FIELD_NAME, bytes(indexPosition_)) +
      field(rosbag::CONNECTION_COUNT_FIELD_NAME, bytes(static_cast<std::uint32_t>(connections_.size()))) +
      field(rosbag::CHUNK_COUNT_FIELD_NAME, bytes(static_cast<std::uint32_t>(chunks_.size())));
  writeBytes(withLength(header) + withLength(std::string(rosbag::FILE_HEADER_LENGTH - header.size(), ' ')));
}

BagWriter::Connections::iterator BagWriter::addConnection(const std::string& topic, const std::string& type,
                                                          const std::string& md5,
                                                          const std::string& definition, bool latched) {
  Connection connection;
  connection.id = static_cast<std::uint32_t>(connections_.size());
  std::string about = field("topic", topic) + field("type", type) + field("md5sum", md5) +
                      field("message_definition", definition);
  if (latched) about += field("latching", "1") + field("callerid", kBagWriterName);
  connection.record =
      withLength(op(rosbag::OP_CONNECTION) + field(rosbag::CONNECTION_FIELD_NAME, bytes(connection.id)) +
                 field(rosbag::TOPIC_FIELD_NAME, topic)) +
      withLength(about);
  chunk_ += connection.record;
  return connections_.emplace(topic, std::move(connection)).first;
}

/// The head of a message's record; returns where its `size` bytes go.
std::uint8_t* BagWriter::beginMessage(Connection& connection, const ros::Time& time, std::uint32_t size) {
  connection.entries.push_back({time, static_cast<std::uint32_t>(chunk_.size())});
  chunk_ += withLength(op(rosbag::OP_MSG_DATA) + field(rosbag::CONNECTION_FIELD_NAME, bytes(connection.id)) +
                       field(rosbag::TIME_FIELD_NAME, bytes(packed(time))));
  chunk_ += bytes(size);
  chunk_.resize(chunk_.size() + size);
  return reinterpret_cast<std::uint8_t*>(chunk_.data() + chunk_.size() - size);
}

void BagWriter::writeChunk() {
  if (chunk_.empty()) return;
  ChunkInfo info{position_, ros::TIME_MAX, ros::Time(), {}};
  std::string index;
  for (auto& [topic, connection] : connections_) {
    if (connection.entries.empty()) continue;
    std::string data;
    for (const Entry& e : connection.entries) {
      data += bytes(packed(e.time)) + bytes(e.offset);
      info.start = std::min(info.start, e.time);
      info.end = std::max(info.end, e.time);
    }
    const auto count = static_cast<std::uint32_t>(connection.entries.size());
    info.counts[connection.id] = count;
    index +=
        withLength(op(rosbag::OP_INDEX_DATA) + field(rosbag::VER_FIELD_NAME, bytes(rosbag::INDEX_VERSION)) +
                   field(rosbag::CONNECTION_FIELD_NAME, bytes(connection.id)) +
                   field(rosbag::COUNT_FIELD_NAME, bytes(count))) +
        withLength(data);
    connection.entries.clear();
  }
  const auto size = static_cast<std::uint32_t>(chunk_.size());
  writeBytes(withLength(op(rosbag::OP_CHUNK) +
                        field(rosbag::COMPRESSION_FIELD_NAME, rosbag::COMPRESSION_NONE) +
                        field(rosbag::SIZE_FIELD_NAME, bytes(size))) +
             bytes(size));
  writeBytes(chunk_);
  writeBytes(index);
  chunk_.clear();
  chunks_.push_back(std::move(info));
}

void BagWriter::close() {
  writeChunk();
  indexPosition_ = position_;
  std::vector<const Connection*> byId(connections_.size());
  for (const auto& entry : connections_) byId[entry.second.id] = &entry.second;
  for (const Connection* connection : byId) writeBytes(connection->record);
  for (const ChunkInfo& info : chunks_) {
    std::string counts;
    for (const auto& [id, count] : info.counts) counts += bytes(id) + bytes(count);
    writeBytes(
        withLength(op(rosbag::OP_CHUNK_INFO) +
                   field(rosbag::VER_FIELD_NAME, bytes(rosbag::CHUNK_INFO_VERSION)) +
                   field(rosbag::CHUNK_POS_FIELD_NAME, bytes(info.position)) +
                   field(rosbag::START_TIME_FIELD_NAME, bytes(packed(info.start))) +
                   field(rosbag::END_TIME_FIELD_NAME, bytes(packed(info.end))) +
                   field(rosbag::COUNT_FIELD_NAME, bytes(static_cast<std::uint32_t>(info.counts.size())))) +
        withLength(counts));
  }
  if (::lseek(file_, static_cast<off_t>(rosbag::VERSION.size() + 10), SEEK_SET) < 0) fail("finished");
  writeFileHeader();
  if (::fsync(file_) != 0) fail("finished");
  const int file = file_;
  file_ = -1;
  if (::close(file) != 0) fail("finished");
}

}  // namespace mm
