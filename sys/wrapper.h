/* The one Embree header, chosen by build.rs, which knows what is installed. */

#pragma once

#if TELAMON_EMBREE_MAJOR == 4
#include <embree4/rtcore.h>
#elif TELAMON_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#error "TELAMON_EMBREE_MAJOR must be 3 or 4; build.rs sets it"
#endif
