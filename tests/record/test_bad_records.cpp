#include <cmath>

#include "base/byte_stream.hpp"
#include "record/trace.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("records of what a rank did are refused when no rank can have done it") {
  for (const int fault : {0, 1, 2, 3}) {
    Bytes sent;
    append(sent, 0.0);  // the clock's time, offset and uncertainty, and that it is common
    append(sent, 0.0);
    append(sent, 0.0);
    append(sent, true);
    append(sent, std::uint64_t{1});  // records
    append(sent, NodeId{fault == 1 ? Role(9) : Role::gp, 0});
    append(sent, false);
    append(sent, std::uint64_t{1});
    Span span;
    if (fault == 2) span.begin = INFINITY;
    if (fault == 3) span.activity = Activity(200);
    append(sent, span);
    append(sent, std::uint64_t{0});
    // Process 0 gathers.
    class Gathering final : public Collectives {
     public:
      explicit Gathering(const Bytes& other) : other_(other.begin(), other.end()) {}
      int process() const override { return 0; }
      int processes() const override { return 2; }
      std::vector<Block> all_to_all(std::vector<Block> out) override {
        out[1] = other_;
        return out;
      }
      std::vector<Block> all_gather(const Block& mine) override { return {mine, mine}; }
      Block broadcast(Block block, int) override { return block; }
      void sum(std::span<std::uint64_t>) override {}
      std::vector<int> absent(double) override { return {}; }

     private:
      Block other_;
    } gathering(sent);
    const Trace trace;
    if (fault == 0)
      CHECK_NOTHROW(trace.gather(gathering));
    else
      CHECK_THROWS_WITH(trace.gather(gathering), Catch::Matchers::Contains("rank 1 sent a broken record"));
  }
}
