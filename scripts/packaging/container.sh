#!/bin/sh
# stof-container [FLAGS OF STOFD]: the emulated sensor of a container; says how to reach it.
port=7560
# shellcheck disable=SC2046
set -- $([ "$#" -gt 0 ] || echo --scene corridor) "$@"
addresses=$(hostname -I 2>/dev/null)
cat <<END
stof: an emulated depth sensor, UDP port $port of ${addresses:-this container}

with --network host, on this computer or beside it:
  stof discover
  stof view 127.0.0.1              a page in the browser
  stof bridge ros2 127.0.0.1       topics of ROS 2
  python3 -c 'import stof; print(next(iter(stof.open("127.0.0.1").frames())).depth)'
without, give docker run -p $port:$port/udp, or use the address above.
in this container: docker exec CONTAINER stof view 127.0.0.1 --frames 5

END
exec stofd "$@"
