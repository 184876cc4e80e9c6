#pragma once
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <charconv>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "base/number_text.h"
#include "base/yaml_mapping.h"
#include "effects/effect_yaml.h"

namespace mm {

// The layout of a YAML file that is told once: a function shows its values to a YamlWriter or to a
// YamlReader, which have the same members.

enum class Style { kBlock, kOneLine };  ///< of each mapping of a list

/// Writes what it is shown; how a value is written follows from its type.
class YamlWriter {
 public:
  static constexpr bool kReads = false;
  /// @param out must outlive it.
  explicit YamlWriter(YAML::Emitter& out) : out_(out) {}

  template <typename T>
  void operator()(const std::string& key, const T& value) {
    out_ << YAML::Key << key << YAML::Value;
    add(value);
  }
  /// A text, or a list of texts a line each, in quotes.
  void quoted(const char* key, const std::string& text) {
    out_ << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << text;
  }
  /// As above.
  void quoted(const char* key, const std::vector<std::string>& texts) {
    out_ << YAML::Key << key << YAML::Value << YAML::BeginSeq;
    for (const std::string& text : texts) out_ << YAML::DoubleQuoted << text;
    out_ << YAML::EndSeq;
  }
  /// A text of many lines, as it is where YAML can hold it so.
  void document(const char* key, const std::string& text) {
    const bool literal = text.size() > 1 && text.front() == '<' && text.back() == '\n' &&
                         text[text.size() - 2] != '\n' && text.find_first_of("\r\t") == std::string::npos;
    if (literal)
      out_ << YAML::Key << key << YAML::Value << YAML::Literal << text.substr(0, text.size() - 1);
    else
      quoted(key, text);
  }
  /// Behind the mapping of a list that is shown now.
  void comment(const std::string& text) { comment_ = text; }

  /// Whether a key that may be missing is there. @param here whether it is to be written.
  bool told(const char* /*key*/, bool here) const { return here; }
  /// Whether a key has a word and no mapping. @param here whether it is to be written so.
  bool isWord(const char* /*key*/, bool here) const { return here; }
  template <typename Show>
  void map(const char* key, Show show) {
    out_ << YAML::Key << key << YAML::Value << YAML::BeginMap;
    show(*this);
    out_ << YAML::EndMap;
  }
  /// Shows each of so many mappings: show(io, index).
  template <typename Show>
  void list(const char* key, std::size_t size, Style style, Show show) {
    out_ << YAML::Key << key << YAML::Value << YAML::BeginSeq;
    for (std::size_t i = 0; i < size; ++i) {
      if (style == Style::kOneLine) out_ << YAML::Flow;
      out_ << YAML::BeginMap;
      show(*this, i);
      out_ << YAML::EndMap;
      if (!comment_.empty()) out_ << YAML::Comment(comment_);
      comment_.clear();
    }
    out_ << YAML::EndSeq;
  }

 private:
  void add(double value) { out_ << numberText(value); }
  void add(bool value) { out_ << value; }
  template <typename Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
  void add(Integer value) {
    out_ << std::to_string(value);
  }
  void add(const std::string& text) { out_ << text; }
  template <typename T>
  void add(const std::vector<T>& row) {
    out_ << YAML::Flow << YAML::BeginSeq;
    for (const T& item : row) add(item);
    out_ << YAML::EndSeq;
  }
  void add(const Eigen::Vector3d& v) { add(std::vector<double>(v.data(), v.data() + v.size())); }
  void add(const EffectSpec& spec) {
    out_ << YAML::Flow << YAML::BeginMap << YAML::Key << "type" << YAML::Value << spec.type;
    for (const auto& [key, value] : spec.keys) {
      out_ << YAML::Key << key << YAML::Value;
      if (value.list)
        add(value.items);
      else
        add(value.items.empty() ? std::string() : value.items.front());
    }
    out_ << YAML::EndMap;
  }
  void add(const std::vector<EffectSpec>& specs) {
    out_ << YAML::BeginSeq;
    for (const EffectSpec& spec : specs) add(spec);
    out_ << YAML::EndSeq;
  }
  /// A covariance; a symmetric one is written as its lower triangle.
  void add(const Eigen::MatrixXd& matrix) {
    const bool symmetric = matrix == matrix.transpose();
    out_ << YAML::BeginSeq;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
      const Eigen::VectorXd row = matrix.row(i).head(symmetric ? i + 1 : matrix.cols());
      add(std::vector<double>(row.data(), row.data() + row.size()));
    }
    out_ << YAML::EndSeq;
  }

  YAML::Emitter& out_;
  std::string comment_;
};

/// Fills what it is shown with what the file has. @throw InputError naming the key, each.
class YamlReader {
 public:
  static constexpr bool kReads = true;
  /// @param path of this mapping, with a dot behind it; empty: the file's own.
  explicit YamlReader(YamlMapping keys, std::string path = {})
      : keys_(std::move(keys)), path_(std::move(path)) {}

  void operator()(const std::string& key, double& value) { value = keys_.stored(key); }
  void operator()(const std::string& key, bool& value) { value = keys_.flag(key); }
  void operator()(const std::string& key, std::string& value) { value = keys_.storedText(key); }
  template <typename Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
  void operator()(const std::string& key, Integer& value) {
    const std::string text = keys_.storedText(key);
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size())
      throw InputError("'" + key + "' is '" + text + "', which is not a whole number in its range");
  }
  void operator()(const std::string& key, std::vector<double>& values) { values = keys_.storedList(key); }
  void operator()(const std::string& key, Eigen::Vector3d& value) {
    const std::vector<double> v = keys_.storedList(key);
    if (v.size() != 3) keys_.refuse(keys_.node(key), "'" + key + "' needs three numbers");
    value = {v[0], v[1], v[2]};
  }
  void operator()(const std::string& key, std::vector<std::string>& names) {
    for (const YAML::Node& name : keys_.list(key)) names.push_back(name.Scalar());
  }
  void operator()(const std::string& key, EffectSpec& spec) {
    spec = effectSpecOf(keys_.node(key), keys_.source());
  }
  void operator()(const std::string& key, std::vector<EffectSpec>& specs) {
    for (const YAML::Node& node : keys_.list(key)) specs.push_back(effectSpecOf(node, keys_.source()));
  }
  /// @param matrix has its size already.
  void operator()(const std::string& key, Eigen::MatrixXd& matrix) {
    const std::vector<YAML::Node> rows = keys_.list(key);
    const Eigen::Index n = matrix.rows();
    if (static_cast<Eigen::Index>(rows.size()) != n)
      keys_.refuse(keys_.node(key), "'" + key + "' needs one row a parameter");
    bool triangle = false;  // as the first row
    for (Eigen::Index i = 0; i < n; ++i) {
      const YAML::Node& node = rows[static_cast<std::size_t>(i)];
      const std::vector<double> row = keys_.storedList(node, key);
      const auto length = static_cast<Eigen::Index>(row.size());
      if (i == 0) triangle = length == 1;
      if (length != (triangle ? i + 1 : n)) keys_.refuse(node, "a row of '" + key + "' has the wrong length");
      for (Eigen::Index j = 0; j < length; ++j) {
        matrix(i, j) = row[static_cast<std::size_t>(j)];
        if (triangle) matrix(j, i) = matrix(i, j);
      }
    }
  }
  /// All that follow: as those of the YamlWriter.
  template <typename T>
  void quoted(const char* key, T& value) {
    (*this)(key, value);
  }
  /// As above.
  void document(const char* key, std::string& text) { (*this)(key, text); }
  void comment(const std::string&) {}  ///< none is read

  bool told(const char* key, bool) const { return keys_.has(key); }  ///< the file decides
  /// The file decides. @throw InputError: there is no such key.
  bool isWord(const char* key, bool) const { return keys_.node(key).IsScalar(); }
  /// @throw InputError: no mapping, or one with unknown keys.
  template <typename Show>
  void map(const char* key, Show show) {
    YamlReader in(keys_.map(key), path_ + key + ".");
    show(in);
    in.keys_.finish();
  }
  /// @throw InputError: no list of mappings, or one with unknown keys.
  template <typename Show>
  void list(const char* key, std::size_t, Style, Show show) {
    const std::vector<YAML::Node> items = keys_.list(key);
    for (std::size_t i = 0; i < items.size(); ++i) {
      YamlReader in(keys_.item(items[i], path_ + key, i));
      show(in, i);
      in.keys_.finish();
    }
  }
  const YamlMapping& keys() const { return keys_; }  ///< of this mapping, for what refuses a value

 private:
  YamlMapping keys_;
  std::string path_;
};

/// Keys and their values, one after the other.
template <typename Io, typename T, typename... More>
void fields(Io& io, const std::string& key, T& value, More&&... more) {
  io(key, value);
  if constexpr (sizeof...(more) > 0) fields(io, more...);
}

/// A key that may be missing. @param here whether it is to be written.
template <typename Io, typename T>
void field(Io& io, const char* key, T& value, bool here) {
  if (io.told(key, here)) io(key, value);
}

/// Item `i` of a list that grows while it is read.
template <typename T>
T& at(std::vector<T>& list, std::size_t i) {
  if (i >= list.size()) list.resize(i + 1);
  return list[i];
}

/// A list of mappings: show(io, item).
template <typename Io, typename T, typename Show>
void items(Io& io, const char* key, std::vector<T>& all, Show show, Style style = Style::kBlock) {
  io.list(key, all.size(), style, [&](Io& in, std::size_t i) { show(in, at(all, i)); });
}

}  // namespace mm
