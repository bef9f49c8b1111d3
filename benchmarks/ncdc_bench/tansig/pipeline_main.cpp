// Feeds a free-running pipeline with ports clk, rst, i, o one value per clock, from and to files of
// 32-bit words. Arguments: input file, output file, latency in clocks.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "Vpipeline.h"
#include "verilated.h"

namespace {

constexpr std::size_t kBlock = 1 << 16;

[[noreturn]] void fail(const char* what) {
    std::printf("FAILED %s\n", what);
    std::exit(1);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) fail("three arguments are needed");
    std::FILE* const inputs = std::fopen(argv[1], "rb");
    std::FILE* const outputs = std::fopen(argv[2], "wb");
    if (!inputs || !outputs) fail("a file cannot be opened");
    std::uint64_t flying = std::strtoull(argv[3], nullptr, 10);

    const auto context = std::make_unique<VerilatedContext>();
    const auto pipeline = std::make_unique<Vpipeline>(context.get());
    pipeline->rst = 0;
    pipeline->clk = 0;
    pipeline->eval();       // the first evaluation sees no edge

    // Outputs before the first input has passed are dropped; the last input's value stays until it
    // has come out.
    std::uint64_t early = flying - 1, extra = 0;
    std::vector<std::uint32_t> in(kBlock), out;
    bool more = true;
    while (more) {
        std::size_t count = std::fread(in.data(), sizeof in[0], kBlock, inputs);
        if (count == 0) {
            more = false;
            extra = flying - 1;
            in.assign(extra, pipeline->i);
            count = extra;
        }
        out.clear();
        for (std::size_t k = 0; k < count; k++) {
            pipeline->i = in[k];
            pipeline->clk = 1;
            pipeline->eval();
            if (early) early--;
            else out.push_back(pipeline->o);
            pipeline->clk = 0;
            pipeline->eval();
        }
        if (std::fwrite(out.data(), sizeof out[0], out.size(), outputs) != out.size())
            fail("the output file cannot be written");
    }
    if (std::fclose(outputs)) fail("the output file cannot be written");
    pipeline->final();
    return 0;
}
