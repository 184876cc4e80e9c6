#include "workbench/contacts_document.h"

#include "base/units.h"
#include "report/json_parts.h"

namespace mm {

WebAnswer ContactsDocument::of(const std::vector<Eigen::Vector3d>& contacts) {
  const bool sameSession =
      count_ > 0 && count_ <= contacts.size() && contacts.front() == first_ && contacts[count_ - 1] == last_;
  if (!sameSession) {
    list_.clear();
    count_ = 0;
    body_ = nullptr;
  }
  if (count_ < contacts.size() || !body_) {
    for (; count_ < contacts.size(); ++count_)
      list_ += (count_ > 0 ? "," : "") + roundedList(contacts[count_] / kMillimetre, kPlaceStep).dump();
    if (count_ > 0) {
      first_ = contacts.front();
      last_ = contacts[count_ - 1];
    }
    body_ = std::make_shared<const std::string>("{\"at_mm\":[" + list_ + "]}");
  }
  WebAnswer answer;
  answer.body = body_;
  return answer;
}

}  // namespace mm
