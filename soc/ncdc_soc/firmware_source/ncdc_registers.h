/* What the driver includes: the registers are in config.h. */
#include "config.h"
