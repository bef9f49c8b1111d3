/* What lwIP must know of the compiler. */
#ifndef CC_H
#define CC_H

#include <stdint.h>

#define LWIP_PLATFORM_DIAG(x)
#define LWIP_PLATFORM_ASSERT(x) lwip_failed()
#define LWIP_RAND() lwip_random()

void lwip_failed(void);
uint32_t lwip_random(void);

#endif
