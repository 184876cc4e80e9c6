#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "workbench/web_handler.h"

namespace mm {

/// The contacts as they come, for the page. Each is written once, however many pages ask however often: there
/// may be 100,000.
class ContactsDocument {
 public:
  /// @param contacts nominal tips of the live session so far, m, workpiece. @return `{"at_mm": [[x, y, z],
  /// …]}`.
  WebAnswer of(const std::vector<Eigen::Vector3d>& contacts);

 private:
  std::string list_;  // what is written of it
  std::size_t count_ = 0;
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero(), last_ = Eigen::Vector3d::Zero();
  std::shared_ptr<const std::string> body_;
};

}  // namespace mm
