#include "ros_bridge/bag_reader.h"

#include <rosbag/chunked_file.h>
#include <rosbag/constants.h>
#include <rosbag/exceptions.h>
#include <rosbag/stream.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <set>

#include "base/error.h"

namespace mm {
namespace {

constexpr std::uint32_t kLongestHeader = 1 << 24;  // bytes; a longer one is damage
constexpr std::size_t kVersionLine = 64;           // bytes; that of a bag has 13
constexpr std::uint32_t kLargestChunk = 1U << 28;  // bytes when unpacked; rosbag begins a new one at 768 KB

template <typename T>
T littleEndian(const void* bytes) {
  T value = 0;
  std::memcpy(&value, bytes, sizeof value);  // ROS runs on little-endian machines only
  return value;
}

/// `name=value` fields, each after its length. False when they do not fill `size` exactly.
bool parseFields(const std::uint8_t* data, std::size_t size, std::map<std::string, std::string>& fields) {
  fields.clear();
  std::size_t at = 0;
  while (at < size) {
    if (size - at < 4) return false;
    const auto length = littleEndian<std::uint32_t>(data + at);
    at += 4;
    if (length > size - at) return false;
    const char* text = reinterpret_cast<const char*>(data + at);
    const auto* equals = static_cast<const char*>(std::memchr(text, rosbag::FIELD_DELIM, length));
    if (equals == nullptr) return false;
    fields[std::string(text, equals)] = std::string(equals + 1, text + length);
    at += length;
  }
  return true;
}

template <typename T>
bool field(const std::map<std::string, std::string>& fields, const std::string& name, T& value) {
  const auto found = fields.find(name);
  if (found == fields.end() || found->second.size() != sizeof(T)) return false;
  value = littleEndian<T>(found->second.data());
  return true;
}

std::string text(const std::map<std::string, std::string>& fields, const std::string& name) {
  const auto found = fields.find(name);
  return found == fields.end() ? std::string() : found->second;
}

}  // namespace

BagReader::BagReader(const std::filesystem::path& file) : path_(file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw InputError(file.string() + ": is a folder, not a bag");
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
    throw InputError(file.string() + ": is not a regular file (a device or a pipe)");
  errno = 0;
  in_.open(file, std::ios::binary);
  if (!in_) {
    const std::string why = errno == 0 || errno == ENOENT ? "does it exist?" : std::strerror(errno);
    throw InputError(file.string() + ": the bag cannot be read; " + why);
  }
  size_ = std::filesystem::file_size(file, error);
  std::string version;
  for (char c = 0; version.size() < kVersionLine && in_.get(c) && c != '\n';) version += c;
  refuseIfTheDiskFails();
  if (version.rfind("#ROSBAG V", 0) != 0)
    throw InputError(file.string() +
                     ": is not a bag (its first line says so); a table of measurements becomes one by mm "
                     "import");
  if (version != "#ROSBAG V2.0")
    throw InputError(file.string() + ": is a bag of format " + version.substr(9) +
                     ", but 2.0 is needed; convert it with 'rosbag fix'");
}

void BagReader::refuseIfTheDiskFails() const {
  if (in_.bad())
    throw InputError(path_.string() +
                     ": the bag cannot be read to its end: the disk reports an error; read it again, or use "
                     "another copy");
}

std::vector<BagConnection> BagReader::indexedConnections() {
  Fields fields;
  std::vector<std::uint8_t> data;
  bool whole = true;
  const bool header =
      readRecord(fields, data, whole) && handleRecord(fields, {data.data(), data.size()}, whole);
  refuseIfTheDiskFails();
  if (!header || indexPosition_ == 0 || indexPosition_ >= size_) return {};
  in_.seekg(static_cast<std::streamoff>(indexPosition_));
  std::vector<BagConnection> found;
  unsigned char op = 0;
  while (readRecord(fields, data, whole) && whole && field(fields, rosbag::OP_FIELD_NAME, op) &&
         op == rosbag::OP_CONNECTION && handleConnection(fields, {data.data(), data.size()})) {
  }
  refuseIfTheDiskFails();
  for (const auto& entry : connections_) found.push_back(entry.second);
  return found;
}

std::vector<std::string> BagReader::topics() const {
  std::set<std::string> topics;
  for (const auto& entry : connections_) topics.insert(entry.second.topic);
  return {topics.begin(), topics.end()};
}

void BagReader::read(const std::function<void(const BagMessage&)>& take, const ProgressCallback& progress) {
  take_ = take;
  Fields fields;
  std::vector<std::uint8_t> data;
  bool whole = true;
  std::uint64_t start = 0;
  bool good = true;
  while (good && (start = static_cast<std::uint64_t>(in_.tellg())) < size_) {
    good =
        readRecord(fields, data, whole) && handleRecord(fields, {data.data(), data.size()}, whole) && whole;
    if (progress) progress(static_cast<double>(start) / static_cast<double>(size_));
  }
  refuseIfTheDiskFails();
  const std::string read = std::to_string(messages_) + " messages";
  if (!good)
    damage_ = "damaged or truncated at byte " + std::to_string(start) + ": read up to there, " + read;
  else if (indexPosition_ == 0)
    damage_ = "the bag has no index (its recording was not closed): read to its end, " + read;
  else if (indexPosition_ > size_ || chunkInfos_ < chunksPromised_)
    damage_ = "the bag is truncated (its index is lost): read to its end, " + read;
}

/// Reads the next record; `whole` is false when its data ends with the file. False: no record is here.
bool BagReader::readRecord(Fields& fields, std::vector<std::uint8_t>& data, bool& whole) {
  const auto readBytes = [&](std::uint32_t count) {
    // a damaged length must not ask for more memory than the file can fill
    const auto at = static_cast<std::uint64_t>(in_.tellg());
    data.resize(std::min<std::uint64_t>(count, size_ > at ? size_ - at : 0));
    in_.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size()));
    const auto got = static_cast<std::size_t>(in_.gcount());
    data.resize(got);
    return got == count;
  };
  if (!readBytes(4)) return false;
  const auto headerLength = littleEndian<std::uint32_t>(data.data());
  if (headerLength > kLongestHeader || !readBytes(headerLength)) return false;
  if (!parseFields(data.data(), data.size(), fields)) return false;
  if (!readBytes(4)) return false;
  const auto length = littleEndian<std::uint32_t>(data.data());
  const std::uint64_t left = size_ - std::min<std::uint64_t>(size_, static_cast<std::uint64_t>(in_.tellg()));
  whole = length <= left;
  return readBytes(static_cast<std::uint32_t>(std::min<std::uint64_t>(length, left)));
}

bool BagReader::handleRecord(const Fields& fields, Bytes data, bool whole) {
  unsigned char op = 0;
  if (!field(fields, rosbag::OP_FIELD_NAME, op)) return false;
  switch (op) {
    case rosbag::OP_FILE_HEADER:
      return field(fields, rosbag::INDEX_POS_FIELD_NAME, indexPosition_) &&
             field(fields, rosbag::CHUNK_COUNT_FIELD_NAME, chunksPromised_);
    case rosbag::OP_CHUNK:
      return handleChunk(fields, data, whole);
    case rosbag::OP_CONNECTION:
      return whole && handleConnection(fields, data);
    case rosbag::OP_MSG_DATA: {  // in a chunk, or behind the header of a chunk that was never closed
      std::uint32_t id = 0;
      const auto found =
          field(fields, rosbag::CONNECTION_FIELD_NAME, id) ? connections_.find(id) : connections_.end();
      if (!whole || found == connections_.end()) return false;
      ++messages_;
      take_({&found->second, data.data, static_cast<std::uint32_t>(data.size)});
      return true;
    }
    case rosbag::OP_CHUNK_INFO:
      ++chunkInfos_;
      return whole;
    case rosbag::OP_INDEX_DATA:
      return whole;
    default:
      return false;
  }
}

bool BagReader::handleConnection(const Fields& fields, Bytes data) {
  std::uint32_t id = 0;
  Fields definition;
  if (!field(fields, rosbag::CONNECTION_FIELD_NAME, id) || !parseFields(data.data, data.size, definition))
    return false;
  const std::string topic = text(fields, rosbag::TOPIC_FIELD_NAME);
  connections_[id] = {topic, text(definition, "type"), text(definition, "md5sum"),
                      text(definition, "callerid")};
  return !topic.empty();
}

bool BagReader::handleChunk(const Fields& fields, Bytes data, bool whole) {
  const std::string compression = text(fields, rosbag::COMPRESSION_FIELD_NAME);
  std::uint32_t size = 0;
  if (!field(fields, rosbag::SIZE_FIELD_NAME, size) || size > kLargestChunk) return false;
  if (compression == rosbag::COMPRESSION_NONE) return handleContents(data);
  const bool bz2 = compression == rosbag::COMPRESSION_BZ2;
  if (!whole || (!bz2 && compression != rosbag::COMPRESSION_LZ4)) return false;
  // Memory that is zero and not there until it is written to: a damaged size alone takes none.
  const std::unique_ptr<void, decltype(&std::free)> contents(std::calloc(std::max<std::uint32_t>(size, 1), 1),
                                                             &std::free);
  if (contents == nullptr) return false;
  auto* const unpacked = static_cast<std::uint8_t*>(contents.get());
  std::vector<std::uint8_t> packed(data.data, data.data + data.size);
  try {
    rosbag::ChunkedFile none;  // the streams want a file, and do not touch it here
    rosbag::StreamFactory streams(&none);
    streams.getStream(bz2 ? rosbag::compression::BZ2 : rosbag::compression::LZ4)
        ->decompress(unpacked, size, packed.data(), static_cast<unsigned int>(packed.size()));
  } catch (const rosbag::BagException&) {
    return false;
  }
  return handleContents({unpacked, size});
}

/// The records inside a chunk; false when they end before it does.
bool BagReader::handleContents(Bytes contents) {
  Fields fields;
  std::size_t at = 0;
  const auto lengthAt = [&](std::uint32_t& length) {
    if (contents.size - at < 4) return false;
    length = littleEndian<std::uint32_t>(contents.data + at);
    at += 4;
    return length <= contents.size - at;
  };
  while (at < contents.size) {
    std::uint32_t length = 0;
    if (!lengthAt(length) || !parseFields(contents.data + at, length, fields)) return false;
    at += length;
    unsigned char op = 0;  // a chunk in a chunk is damage
    if (!field(fields, rosbag::OP_FIELD_NAME, op) || op == rosbag::OP_CHUNK) return false;
    if (!lengthAt(length) || !handleRecord(fields, {contents.data + at, length}, true)) return false;
    at += length;
  }
  return true;
}

}  // namespace mm
