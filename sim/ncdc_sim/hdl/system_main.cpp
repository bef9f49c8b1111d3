// Drives the two clocks of the system bench under Verilator, each with its own period: plusargs
// clk_period and extclk_period in ps, extclk_phase in ps for the first edge of the latter.

#include <cstdlib>
#include <cstring>
#include <memory>

#include "Vsystem_bench.h"
#include "verilated.h"
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

static uint64_t number(int argc, char** argv, const char* name, uint64_t otherwise) {
    for (int k = 1; k < argc; ++k)
        if (!strncmp(argv[k], name, strlen(name))) return strtoull(argv[k] + strlen(name), nullptr, 10);
    return otherwise;
}

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const uint64_t half = number(argc, argv, "+clk_period=", 10000) / 2;
    const uint64_t other_half = number(argc, argv, "+extclk_period=", 10000) / 2;
    uint64_t next = half, other = number(argc, argv, "+extclk_phase=", other_half);
    const auto bench = std::make_unique<Vsystem_bench>(context.get());
    while (!context->gotFinish()) {
        const uint64_t now = next < other ? next : other;
        context->time(now);
        if (now == next) {
            bench->clk = !bench->clk;
            next += half;
        }
        if (now == other) {
            bench->extclk = !bench->extclk;
            other += other_half;
        }
        bench->eval();
    }
    bench->final();
#if VM_COVERAGE
    context->coveragep()->write("coverage.dat");
#endif
    return 0;
}
