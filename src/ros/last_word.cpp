#include <chrono>
#include <csignal>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <dlfcn.h>
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>
#include <semaphore.h>

#include <frugal_nav/ros/last_word.hpp>

namespace frugal_nav {
namespace {

constexpr std::chrono::milliseconds kLongestWait{500};
constexpr std::chrono::milliseconds kToSend{100};  // roscpp sends from another thread, which tells nobody

class Call : public ros::CallbackInterface {
 public:
  explicit Call(std::function<void()> function) : function_(std::move(function)) {}
  CallResult call() override {
    function_();
    return Success;
  }

 private:
  std::function<void()> function_;
};

/// The one of a process. It stays until the process ends, since a signal handler cannot be taken back safely.
class Farewell {
 public:
  static Farewell& instance() {
    static auto* farewell = new Farewell;
    return *farewell;
  }

  std::uint64_t add(ros::CallbackQueueInterface& queue, std::function<void()> say) {
    const std::lock_guard<std::mutex> lock(mutex_);
    words_[++last_id_] = Word{&queue, std::make_shared<std::function<void()>>(std::move(say))};
    return last_id_;
  }
  void remove(std::uint64_t id) {
    const std::lock_guard<std::mutex> lock(mutex_);
    words_.erase(id);
  }

 private:
  struct Word {
    ros::CallbackQueueInterface* queue = nullptr;
    std::shared_ptr<std::function<void()>> say;
  };

  Farewell() {
    // The handlers outlive the last nodelet: so must their code, though the manager unloads the library.
    Dl_info library{};
    if (dladdr(reinterpret_cast<void*>(&Farewell::onSignal), &library) != 0)
      dlopen(library.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
    sem_init(&asked_, 0, 0);
    std::thread([this] { run(); }).detach();
    std::signal(SIGINT, &Farewell::onSignal);
    std::signal(SIGTERM, &Farewell::onSignal);
    ros::XMLRPCManager::instance()->unbind("shutdown");
    ros::XMLRPCManager::instance()->bind("shutdown", &Farewell::onShutdownRequest);
  }

  static void onSignal(int) { sem_post(&asked_); }
  static void onShutdownRequest(XmlRpc::XmlRpcValue&, XmlRpc::XmlRpcValue& result) {
    sem_post(&asked_);
    result = ros::xmlrpc::responseInt(1, "", 0);
  }

  void run() {
    while (sem_wait(&asked_) != 0) {
    }
    for (const auto& done : sayAll()) done->get_future().wait_for(kLongestWait);
    std::this_thread::sleep_for(kToSend);
    ros::requestShutdown();
  }

  std::vector<std::shared_ptr<std::promise<void>>> sayAll() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<std::shared_ptr<std::promise<void>>> all_done;
    for (const auto& [id, word] : words_) {
      auto done = std::make_shared<std::promise<void>>();
      word.queue->addCallback(boost::make_shared<Call>([done, say = word.say] {
                                (*say)();
                                done->set_value();
                              }),
                              id);
      all_done.push_back(done);
    }
    return all_done;
  }

  inline static sem_t asked_;
  std::mutex mutex_;
  std::map<std::uint64_t, Word> words_;
  std::uint64_t last_id_ = 0;
};

}  // namespace

LastWord::LastWord(ros::CallbackQueueInterface& queue, std::function<void()> say)
    : id_(Farewell::instance().add(queue, std::move(say))) {}

LastWord::~LastWord() { Farewell::instance().remove(id_); }

}  // namespace frugal_nav
