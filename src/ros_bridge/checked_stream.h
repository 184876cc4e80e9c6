#pragma once
#include <ros/serialization.h>

#include <cstdint>
#include <string>
#include <vector>

namespace mm {

/// Deserialises a message that may be damaged: a stated length which the message cannot hold ends it before
/// memory is asked for. roscpp's own IStream takes gigabytes for four wrong bytes.
/// @throw ros::serialization::StreamOverrunException.
class CheckedStream : public ros::serialization::Stream {
 public:
  static const ros::serialization::StreamType stream_type = ros::serialization::stream_types::Input;
  CheckedStream(const std::uint8_t* data, std::uint32_t size)
      : Stream(const_cast<std::uint8_t*>(data), size) {}  // which is only read

  /// The next item; called by the serializers of the messages, too.
  template <typename T>
  void next(T& item) {
    ros::serialization::deserialize(*this, item);
  }
  /// A text, of which the length is checked before it is read.
  void next(std::string& text) {
    const std::uint32_t length = nextLength();
    const auto* bytes = reinterpret_cast<const char*>(advance(length));
    text.assign(bytes, length);
  }
  /// A list, refused where it claims to be longer than all that is left.
  template <typename T>
  void next(std::vector<T>& items) {
    const std::uint32_t length = nextLength();
    items.clear();
    for (std::uint32_t i = 0; i < length; ++i) next(items.emplace_back());
  }

 private:
  /// Whatever is counted, one of it takes a byte at least.
  std::uint32_t nextLength() {
    std::uint32_t length = 0;
    next(length);
    if (length > getLength()) ros::serialization::throwStreamOverrun();
    return length;
  }
};

}  // namespace mm
