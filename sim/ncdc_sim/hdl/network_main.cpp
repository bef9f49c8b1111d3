// Drives the clocks of the network bench under Verilator, each with its own period in ps: plusargs
// clk_period, line_period, extclk_period and pixel_period; 0: that clock stands still.

#include <cstdlib>
#include <cstring>
#include <memory>

#include "Vnetwork_bench.h"
#include "verilated.h"

static uint64_t number(int argc, char** argv, const char* name) {
    for (int k = 1; k < argc; ++k)
        if (!strncmp(argv[k], name, strlen(name))) return strtoull(argv[k] + strlen(name), nullptr, 10);
    return 0;
}

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const auto bench = std::make_unique<Vnetwork_bench>(context.get());
    struct {
        CData& pin;
        uint64_t half, next;
    } clocks[] = {{bench->clk, number(argc, argv, "+clk_period=") / 2, 0},
                  {bench->line, number(argc, argv, "+line_period=") / 2, 0},
                  {bench->extclk, number(argc, argv, "+extclk_period=") / 2, 0},
                  {bench->pixel, number(argc, argv, "+pixel_period=") / 2, 0}};
    // The first edges of no two clocks come together.
    uint64_t phase = 0;
    for (auto& clock : clocks) clock.next = clock.half ? clock.half + 500 * phase++ : ~0ull;
    while (!context->gotFinish()) {
        uint64_t now = ~0ull;
        for (const auto& clock : clocks)
            if (clock.next < now) now = clock.next;
        context->time(now);
        for (auto& clock : clocks)
            if (clock.next == now) {
                clock.pin = !clock.pin;
                clock.next += clock.half;
            }
        bench->eval();
    }
    bench->final();
    return 0;
}
