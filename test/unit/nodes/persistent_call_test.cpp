#include "nodes/persistent_call.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace mm {
namespace {

struct Question {
  int answer = 0;
};

/// A connection that holds by its own word until it is shut, whatever became of its other end.
struct Client {
  struct Link {
    bool open = true, answers = true;
    int calls = 0;
  };
  std::shared_ptr<Link> link;
  bool isValid() const { return link && link->open; }
  bool call(Question& question) const {
    ++link->calls;
    question.answer = 7;
    return link->answers;
  }
  void shutdown() const {
    if (link) link->open = false;
  }
};

struct Service {
  std::vector<std::shared_ptr<Client::Link>> opened;
  int deaf = 0;  // so many connections end while they are opened
  PersistentCall<Question, Client> call{[this] {
    opened.push_back(std::make_shared<Client::Link>());
    opened.back()->answers = static_cast<int>(opened.size()) > deaf;
    return Client{opened.back()};
  }};
};

TEST(PersistentCall, KeepsAConnectionThatAnswers) {
  Service service;
  Question question;
  EXPECT_FALSE(service.call.connected());
  EXPECT_FALSE(service.call.call(question, 1.0)) << "nothing is open yet";
  ASSERT_TRUE(service.call.connect());
  EXPECT_TRUE(service.call.call(question, 1.0));
  EXPECT_TRUE(service.call.callAnew(question, 1.0));
  EXPECT_EQ(question.answer, 7);
  EXPECT_EQ(service.opened.size(), 1U);
}

TEST(PersistentCall, AConnectionThatDoesNotAnswerIsClosedThoughItSaysThatItHolds) {
  Service service;
  service.deaf = 1;
  ASSERT_TRUE(service.call.connect());
  Question question;
  EXPECT_FALSE(service.call.call(question, 1.0));
  EXPECT_EQ(question.answer, 0) << "what was not answered is as it was";
  EXPECT_FALSE(service.call.connected());
  ASSERT_TRUE(service.call.connect());
  EXPECT_TRUE(service.call.call(question, 1.0));
}

TEST(PersistentCall, ACallThatMustArriveTakesANewConnectionOnce) {
  Service service;
  service.deaf = 1;
  ASSERT_TRUE(service.call.connect());
  Question question;
  EXPECT_TRUE(service.call.callAnew(question, 1.0));
  EXPECT_EQ(question.answer, 7);
  EXPECT_EQ(service.opened.size(), 2U);

  Service gone;
  gone.deaf = 9;
  EXPECT_FALSE(gone.call.callAnew(question, 1.0));
  EXPECT_EQ(gone.opened.size(), 1U);
}

}  // namespace
}  // namespace mm
