#include "workbench/documents.h"

namespace mm {

void Documents::put(const std::string& name, std::string body, const std::string& type,
                    const std::string& fileName) {
  if (body.empty()) return remove(name);
  WebAnswer answer = WebAnswer::text(std::move(body), type);
  answer.fileName = fileName;
  const std::lock_guard<std::mutex> lock(mutex_);
  documents_[name] = {++last_, std::move(answer)};
}

void Documents::remove(const std::string& name) {
  const std::lock_guard<std::mutex> lock(mutex_);
  documents_.erase(name);
}

std::optional<WebAnswer> Documents::find(const std::string& name) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = documents_.find(name);
  if (found == documents_.end()) return std::nullopt;
  return found->second.answer;
}

std::map<std::string, std::uint64_t> Documents::numbers() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::map<std::string, std::uint64_t> numbers;
  for (const auto& [name, document] : documents_) numbers[name] = document.number;
  return numbers;
}

}  // namespace mm
