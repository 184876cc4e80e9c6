#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "session/progress.h"

namespace mm {

/// One publisher of a topic in a bag.
struct BagConnection {
  std::string topic, type, md5;
  std::string caller;  // node that published; empty: not told
};

/// One serialized message, valid during the callback.
struct BagMessage {
  const BagConnection* connection;
  const std::uint8_t* data;
  std::uint32_t size;
};

/// Reads a bag (format 2.0) from its beginning, without its index: rosbag itself refuses a bag whose
/// recording was killed or whose end is lost. Compressed chunks are unpacked by rosbag.
class BagReader {
 public:
  /// @throw InputError when the file cannot be opened, is no file (a device), or not a bag of format 2.0.
  explicit BagReader(const std::filesystem::path& file);

  /// Gives every message to `take`, in the order of the file, up to the end or the damage. @throw InputError
  /// when the disk fails: what it did not give is no damage of the bag.
  void read(const std::function<void(const BagMessage&)>& take, const ProgressCallback& progress = {});

  /// Those that the index at the end of the bag names; none where that is missing or damaged. Reads nothing
  /// else. @throw InputError when the disk fails.
  std::vector<BagConnection> indexedConnections();

  const std::string& damage() const { return damage_; }  ///< in words for people; empty: the bag is whole
  std::vector<std::string> topics() const;               ///< that have a connection, sorted

 private:
  using Fields = std::map<std::string, std::string>;
  struct Bytes {
    const std::uint8_t* data;
    std::size_t size;
  };
  void refuseIfTheDiskFails() const;
  bool readRecord(Fields& fields, std::vector<std::uint8_t>& data, bool& whole);
  bool handleRecord(const Fields& fields, Bytes data, bool whole);
  bool handleChunk(const Fields& fields, Bytes data, bool whole);
  bool handleContents(Bytes contents);
  bool handleConnection(const Fields& fields, Bytes data);

  std::filesystem::path path_;
  std::ifstream in_;
  std::uint64_t size_ = 0, indexPosition_ = 0;
  std::uint32_t chunksPromised_ = 0, chunkInfos_ = 0;
  std::map<std::uint32_t, BagConnection> connections_;
  std::function<void(const BagMessage&)> take_;
  std::int64_t messages_ = 0;
  std::string damage_;
};

}  // namespace mm
