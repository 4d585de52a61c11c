/* systemd.h - what a daemon and systemd say to each other: the only door to libsystemd. Started by
 * anything else, systemd_socket is -1 and the rest does nothing. Test: http.systemd.
 */
#ifndef SCATTERD_SYSTEMD_H
#define SCATTERD_SYSTEMD_H

#include "fault.h"

/* The listening stream socket that systemd opened for this process (socket activation), -1 if
 * there is none. False if it passed several, or what is no listening stream socket. */
bool systemd_socket(int *fd, fault *why);

/* The unit is up; it reads its files again, until it is up once more; it is stopping and may take
 * `seconds` for that. */
void systemd_ready(void);
void systemd_reloading(void);
void systemd_stopping(double seconds);

#endif
