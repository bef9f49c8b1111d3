// Feeds a CSI-2 receiver, module `csi2` with ports clk, rst, settings, i and o, from a file of
// 64-bit words: `i`, with the reset in bit 63. Writes `o` of each clock in 64 bits. It ends with a valid
// bit of each sample and the samples; those that are not valid are written as 0. Arguments: input file, output file, settings, first valid bit, number of
// samples, bits of each, plusargs.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "Vcsi2.h"
#include "verilated.h"

namespace {

constexpr std::size_t kBlock = 1 << 16;

[[noreturn]] void fail(const char* what) {
    std::printf("FAILED %s\n", what);
    std::exit(1);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 7) fail("six arguments are needed");
    std::FILE* const inputs = std::fopen(argv[1], "rb");
    std::FILE* const outputs = std::fopen(argv[2], "wb");
    if (!inputs || !outputs) fail("a file cannot be opened");

    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const auto receiver = std::make_unique<Vcsi2>(context.get());
    receiver->settings = std::strtoul(argv[3], nullptr, 10);
    const int valid = std::atoi(argv[4]), samples = std::atoi(argv[5]), bits = std::atoi(argv[6]);
    const auto seen = [=](std::uint64_t o) {
        for (int k = 0; k < samples; k++)
            if (!(o >> (valid + k) & 1))
                o &= ~(((std::uint64_t{1} << bits) - 1) << (valid + samples + bits * k));
        return o;
    };
    receiver->clk = 0;
    receiver->eval();       // the first evaluation sees no edge

    std::vector<std::uint64_t> in(kBlock), out;
    while (const std::size_t count = std::fread(in.data(), sizeof in[0], kBlock, inputs)) {
        out.clear();
        for (std::size_t k = 0; k < count; k++) {
            receiver->i = in[k] & ~(std::uint64_t{1} << 63);
            receiver->rst = in[k] >> 63;
            receiver->clk = 1;
            receiver->eval();
            out.push_back(seen(receiver->o));
            receiver->clk = 0;
            receiver->eval();
        }
        if (std::fwrite(out.data(), sizeof out[0], out.size(), outputs) != out.size())
            fail("the output file cannot be written");
    }
    if (std::fclose(outputs)) fail("the output file cannot be written");
    receiver->final();
    return 0;
}
