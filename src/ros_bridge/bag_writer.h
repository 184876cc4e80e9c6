#pragma once
#include <ros/serialization.h>
#include <ros/time.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace mm {

/// Who published what stands in a bag that was not recorded from nodes.
inline constexpr const char* kBagWriterName = "/measuring_machine";

/// Writes a bag of format 2.0, uncompressed, with its index. rosbag's own writer seeks before every message
/// and ends the program when the disk fills up; this one writes a chunk at a time and reports what the system
/// said.
class BagWriter {
 public:
  /// @param shownAs the name of the file in messages. @throw InputError when the file cannot be made.
  BagWriter(const std::filesystem::path& file, std::string shownAs);
  ~BagWriter();  ///< without `close` the file stays unfinished
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// @param latched replayed as a latched topic. @throw InputError when the disk is full.
  template <typename Message>
  void write(const std::string& topic, const ros::Time& time, const Message& message, bool latched = false) {
    namespace traits = ros::message_traits;
    auto found = connections_.find(topic);
    if (found == connections_.end())
      found = addConnection(topic, traits::DataType<Message>::value(), traits::MD5Sum<Message>::value(),
                            traits::Definition<Message>::value(), latched);
    const std::uint32_t size = ros::serialization::serializationLength(message);
    ros::serialization::OStream stream(beginMessage(found->second, time, size), size);
    ros::serialization::serialize(stream, message);
    if (chunk_.size() >= kChunk) writeChunk();
  }

  /// Writes the index and makes sure that all is on the disk. @throw InputError.
  void close();

 private:
  static constexpr std::size_t kChunk = 768 * 1024;  // bytes, as rosbag
  struct Entry {
    ros::Time time;
    std::uint32_t offset;  // in the chunk
  };
  struct Connection {
    std::uint32_t id = 0;
    std::string record;          // as it stands in the file
    std::vector<Entry> entries;  // of the open chunk
  };
  struct ChunkInfo {
    std::uint64_t position;
    ros::Time start, end;                           // stamps of its messages
    std::map<std::uint32_t, std::uint32_t> counts;  // messages of each connection
  };
  using Connections = std::map<std::string, Connection>;

  Connections::iterator addConnection(const std::string& topic, const std::string& type,
                                      const std::string& md5, const std::string& definition, bool latched);
  std::uint8_t* beginMessage(Connection& connection, const ros::Time& time, std::uint32_t size);
  void writeChunk();
  void writeFileHeader();
  void writeBytes(const void* data, std::size_t size);
  void writeBytes(const std::string& bytes) { writeBytes(bytes.data(), bytes.size()); }
  [[noreturn]] void fail(const std::string& doing) const;

  std::string shownAs_;
  int file_ = -1;
  std::uint64_t position_ = 0, indexPosition_ = 0;
  std::string chunk_;
  Connections connections_;
  std::vector<ChunkInfo> chunks_;
};

}  // namespace mm
