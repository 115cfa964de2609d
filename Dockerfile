# The tool and the Python module on Debian 12:   docker build -t veridyn .   docker run --rm -v "$PWD":/work veridyn info ROBOT.urdf
# On Ubuntu: --build-arg BASE=ubuntu:24.04 (or 22.04).
ARG BASE=debian:12-slim
FROM ${BASE} AS build
RUN apt-get update -qq && apt-get install -y -qq --no-install-recommends make ca-certificates && rm -rf /var/lib/apt/lists/*
COPY . /src/veridyn
WORKDIR /src/veridyn
RUN make deb && mkdir /packages && cp build/debs/*.deb /packages

FROM ${BASE}
COPY --from=build /packages /packages
RUN apt-get update -qq && apt-get install -y -qq --no-install-recommends /packages/*.deb && rm -rf /packages /var/lib/apt/lists/*
WORKDIR /work
ENTRYPOINT ["veridyn"]
