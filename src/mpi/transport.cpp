#include <dlfcn.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <list>
#include <thread>
#include <vector>

#include "base/byte_stream.hpp"
#include "mpi/connections.hpp"

namespace ringsplat {
namespace {

constexpr int message_tag = 1, part_tag = 2;

/// Told that ranks share cores, Open MPI yields at each look for messages. By that a working rank with a core
/// of its own loses up to a quarter of its time. The parameter is read at the start only, so this calls what
/// it sets; other MPI libraries do not have that. Returns whether it yielded.
bool let_mpi_yield(bool yields) {
  using Set = bool (*)(bool);
  static const auto set = reinterpret_cast<Set>(dlsym(RTLD_DEFAULT, "opal_progress_set_yield_when_idle"));
  return set != nullptr && set(yields);
}

/// Where a rank shares its core with other programs, what has come for it waits until their slices of time
/// are over. With short slices of its own it comes sooner. Linux before 6.12 takes no notice.
void ask_for_short_slices() {
  struct {
    std::uint32_t size, policy;
    std::uint64_t flags, nice_and_priority, slice, deadline, period;
  } attributes{};  // Linux's sched_attr, which few C libraries have
  if (syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0) != 0) return;
  attributes.slice = 100'000;
  if (attributes.policy == SCHED_OTHER) syscall(SYS_sched_setattr, 0, &attributes, 0);
}

/// Whole messages over MPI_Isend and matched probes.
///
/// It does its own waiting. Open MPI yields only when it knows of oversubscription, which launchers and
/// containers hide from it, and a blocking receive on shared cores costs hundreds of microseconds a hop.
class MpiTransport final : public Transport {
 public:
  MpiTransport(MPI_Comm comm, std::size_t largest_part) : comm_(comm), largest_part_(largest_part) {
    // MPI knows who shares this machine; the launcher's word on that is lost in containers and under srun.
    MPI_Comm here = MPI_COMM_NULL;
    checked(MPI_Comm_split_type(comm_.get(), MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here),
            "MPI_Comm_split_type");
    MPI_Comm_size(here, &ranks_here_);
    MPI_Comm_free(&here);
    yields_ = yields_among(ranks_here_);
    working_ = comm_.ranks();
    // With the default timer slack a sleep of 20 microseconds takes 70.
    prctl(PR_SET_TIMERSLACK, 1000UL);
    ask_for_short_slices();
  }

  ~MpiTransport() override {
    if (kept_from_yielding_) let_mpi_yield(true);
    // Requests are still open only after a failure; all that is left is to give them up.
    for (auto& sending : sending_)
      for (auto& request : sending.requests)
        if (request != MPI_REQUEST_NULL) MPI_Request_free(&request);
  }

  int rank() const override { return comm_.rank(); }
  int ranks() const override { return comm_.ranks(); }

  void send(int destination, Message message) override {
    sending_.push_back({std::move(message), {}});
    Sending& sending = sending_.back();
    const auto block = sending.message.seal();
    const std::size_t first = std::min(block.size(), largest_part_);
    start(sending, block.first(first), destination, message_tag);
    for (std::size_t at = first; at < block.size(); at += largest_part_)
      start(sending, block.subspan(at, std::min(largest_part_, block.size() - at)), destination, part_tag);
  }

  std::optional<Message> receive() override {
    int arrived = 0;
    MPI_Message matched = MPI_MESSAGE_NULL;
    MPI_Status status;
    checked(MPI_Improbe(MPI_ANY_SOURCE, message_tag, comm_.get(), &arrived, &matched, &status),
            "MPI_Improbe");
    if (arrived == 0) return std::nullopt;
    int count = 0;
    checked(MPI_Get_count(&status, MPI_BYTE, &count), "MPI_Get_count");
    Bytes block(static_cast<std::size_t>(count));
    checked(MPI_Mrecv(block.data(), count, MPI_BYTE, &matched, MPI_STATUS_IGNORE), "MPI_Mrecv");
    if (block.size() == largest_part_) receive_parts(block, status.MPI_SOURCE);
    return Message::from_wire(std::move(block), status.MPI_SOURCE);
  }

  bool sends_done() override {
    sending_.remove_if([](Sending& sending) {
      auto& requests = sending.requests;
      int done = 0;
      checked(MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE),
              "MPI_Testall");
      return done != 0;
    });
    return sending_.empty();
  }

  void note_progress() override {
    waits_ = 0;
    slept_idly_ = {};
    if (sending_.size() > 16) sends_done();
  }

  void only_first_work(int ranks) override {
    idle_ = rank() >= ranks;
    working_ = ranks;
    const int working_here = std::min(ranks, ranks_here_);
    yields_ = yields_among(working_here);
    if (!idle_ && has_cores_for(working_here)) kept_from_yielding_ |= let_mpi_yield(false);
  }

  void wait_next() override { wait(longest_amid_frame, {}); }

  void wait_between_frames(const Sleep& sleep) override {
    wait(sleep ? longest_with_news : longest_between_frames(working_), sleep);
  }

 private:
  struct Sending {
    Message message;
    std::vector<MPI_Request> requests;
  };

  void wait(std::chrono::nanoseconds longest, const Sleep& sleep) {
    sends_done();
    if (idle_) return sleep_idly();
    const Pause pause = pause_after(++waits_, yields_, longest);
    if (pause.yields)
      sched_yield();
    else if (pause.sleeps.count() > 0 && sleep)
      sleep(pause.sleeps);
    else if (pause.sleeps.count() > 0)
      std::this_thread::sleep_for(pause.sleeps);
  }

  /// A rank without work only waits for the run's end. It sleeps longer the longer it has waited, so that it
  /// neither takes its core from others nor makes a short run longer.
  void sleep_idly() {
    constexpr std::chrono::nanoseconds shortest{25'000'000}, longest{100'000'000};
    const auto time = std::clamp(slept_idly_ / 16, shortest, longest);
    slept_idly_ += time;
    std::this_thread::sleep_for(time);
  }

  /// Yields before the first sleep: a few where ranks share cores, some ten milliseconds' worth where each
  /// rank has its own.
  static long yields_among(int ranks) { return has_cores_for(ranks) ? 20'000 : 64; }

  static bool has_cores_for(int ranks) { return ranks <= sysconf(_SC_NPROCESSORS_ONLN); }

  void start(Sending& sending, std::span<const std::byte> part, int destination, int tag) {
    checked(MPI_Isend(part.data(), static_cast<int>(part.size()), MPI_BYTE, destination, tag, comm_.get(),
                      &sending.requests.emplace_back(MPI_REQUEST_NULL)),
            "MPI_Isend");
  }

  /// The first part holds the header, which says how much follows; parts of one sender stay in order.
  void receive_parts(Bytes& block, int source) {
    const Header header = Message::header_of(block, source);
    constexpr auto longest = std::uint64_t{1} << 44;  // of any machine's memory, and far from overflow
    const std::size_t total = sizeof(Header) + std::min(header.bytes, longest);
    std::size_t at = block.size();
    if (total < at || header.bytes > longest)
      throw OtherBuild(fmt::format("rank {} sent a {} in parts that says it has {} bytes", source,
                                   name(header.kind), header.bytes));
    block.resize(total);
    while (at < total) {
      const std::size_t part = std::min(largest_part_, total - at);
      checked(MPI_Recv(block.data() + at, static_cast<int>(part), MPI_BYTE, source, part_tag, comm_.get(),
                       MPI_STATUS_IGNORE),
              "MPI_Recv");
      at += part;
    }
  }

  OwnedComm comm_;
  std::size_t largest_part_;
  std::list<Sending> sending_;
  int ranks_here_ = 1, working_ = 1;
  bool idle_ = false, kept_from_yielding_ = false;
  long yields_ = 0, waits_ = 0;
  std::chrono::nanoseconds slept_idly_{0};
};

}  // namespace

std::unique_ptr<Transport> make_mpi_transport(MPI_Comm comm, std::size_t largest_part) {
  return std::make_unique<MpiTransport>(comm, largest_part);
}

}  // namespace ringsplat
